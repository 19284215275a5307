#include "daemon/web/status_feed.hpp"

#include <fmt/format.h>

#include <utility>

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

constexpr std::string_view kFeedName = "the status for open pages";
// A line without meaning keeps connections open, and finds those whose client is gone.
constexpr Duration kBeat = std::chrono::seconds(15);

}  // namespace

class StatusFeed::Page final : public HttpStream {
 public:
  Page(StatusFeed& feed, const std::shared_ptr<HttpRequest>& request)
      : feed_(feed), request_(request), beats_(feed.beats_) {
    feed_.pages_.insert(this);
  }
  ~Page() override { feed_.pages_.erase(this); }

  // Returns the latest status, so that a page that reads slowly misses what is outdated.
  [[nodiscard]] std::string next() override {
    const bool beat_due = std::exchange(beats_, feed_.beats_) != feed_.beats_;
    if (std::exchange(sent_, feed_.version_) != feed_.version_) return feed_.event_;
    return beat_due ? ":\n\n" : "";
  }
  void wake() {
    if (const std::shared_ptr<HttpRequest> request = request_.lock()) request->go_on();
  }

 private:
  StatusFeed& feed_;
  std::weak_ptr<HttpRequest> request_;
  std::uint64_t sent_ = 0, beats_ = 0;
};

StatusFeed::StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event)
    : loop_(loop),
      event_of_(std::move(event)),
      watch_(loop, socket, [this](const Json& status) { tell(status); }) {}

std::string StatusFeed::plain_event(const Json& status) {
  return fmt::format("data: {}\n\n", status.dump(-1, ' ', true, Json::error_handler_t::replace));
}

void StatusFeed::serve(const std::shared_ptr<HttpRequest>& request) {
  const bool first = pages_.empty();
  request->answer(std::make_shared<Page>(*this, request));
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
