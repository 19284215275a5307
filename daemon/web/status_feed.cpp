#include "daemon/web/status_feed.hpp"

#include <fmt/format.h>

#include <utility>

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr std::string_view kFeedName = "the status for open pages";
// A beat keeps connections open, and finds those whose client is gone. The page takes a connection without
// beats for a dead one (start.js).
constexpr Duration kBeat = std::chrono::seconds(5);
constexpr const char* kComment = ":\n\n";
constexpr const char* kBeatEvent = "event: beat\ndata: {}\n\n";

std::string plain_event(const Json& status) {
  return fmt::format("data: {}\n\n", status.dump(-1, ' ', true, Json::error_handler_t::replace));
}

}  // namespace

class StatusFeed::Page final : public HttpStream {
 public:
  Page(StatusFeed& feed, const std::shared_ptr<HttpRequest>& request, MayGoOn may_go_on)
      : feed_(feed), request_(request), may_go_on_(std::move(may_go_on)), beats_(feed.beats_) {
    feed_.pages_.insert(this);
  }
  ~Page() override { feed_.pages_.erase(this); }

  // Returns the latest status, so that a page that reads slowly misses what is outdated.
  [[nodiscard]] std::string next() override {
    const bool beat_due = std::exchange(beats_, feed_.beats_) != feed_.beats_;
    if (std::exchange(sent_, feed_.version_) != feed_.version_) return feed_.event_;
    return beat_due ? feed_.beat_ : "";
  }
  [[nodiscard]] bool has_ended() const override { return !may_go_on_(); }
  void wake() {
    if (const std::shared_ptr<HttpRequest> request = request_.lock()) request->go_on();
  }

 private:
  StatusFeed& feed_;
  std::weak_ptr<HttpRequest> request_;
  MayGoOn may_go_on_;
  std::uint64_t sent_ = 0, beats_ = 0;
};

StatusFeed::StatusFeed(EventLoop& loop, const std::filesystem::path& socket)
    : StatusFeed(loop, socket, plain_event, kBeatEvent) {}

StatusFeed::StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event)
    : StatusFeed(loop, socket, std::move(event), kComment) {}

StatusFeed::StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event, std::string beat)
    : loop_(loop),
      event_of_(std::move(event)),
      beat_(std::move(beat)),
      watch_(loop, socket, [this](const Json& status) { tell(status); }) {}

void StatusFeed::serve(const std::shared_ptr<HttpRequest>& request, MayGoOn may_go_on) {
  const bool first = pages_.empty();
  request->answer(std::make_shared<Page>(*this, request, std::move(may_go_on)));
  if (!first) return;
  watch_.start();
  beat();
}

void StatusFeed::tell(const Json& status) {
  if (!pages_.empty()) return publish(event_of_(status));
  event_.clear();  // the event is outdated when the next page opens
  watch_.stop();
}

void StatusFeed::publish(std::string event) {
  if (event == event_) return;
  event_ = std::move(event);
  ++version_;
  wake_pages();
}

void StatusFeed::beat() {
  if (pages_.empty()) return beat_timer_.reset();
  beat_timer_ = loop_.at(std::chrono::steady_clock::now() + kBeat, kFeedName, [this] {
    ++beats_;
    wake_pages();
    beat();
  });
}

void StatusFeed::wake_pages() {
  const std::set<Page*> pages = pages_;
  for (Page* page : pages)
    page->wake();
}

}  // namespace contourd::web
