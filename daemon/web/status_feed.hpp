// The printer's status for the pages that are open: asks contourd as long as there are some, and passes each
// change on as a server-sent event. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "daemon/system/event_loop.hpp"
#include "daemon/web/http_request.hpp"
#include "daemon/web/printer/status_watch.hpp"

namespace contourd::web {

class StatusFeed {
 public:
  static constexpr std::size_t kMostPages = 16;

  // Returns the server-sent event for a status, or for {"unreachable": "why"}; an empty text is not sent.
  using Event = std::function<std::string(const StatusWatch::Json& status)>;

  // True as long as a page may get the status.
  using MayGoOn = std::function<bool()>;

  // Connects to contourd's control socket when the first page is open. The events are those of the printer's
  // page: statuses, and a "beat" every few seconds, by which scripts notice a connection that is dead.
  StatusFeed(EventLoop& loop, const std::filesystem::path& socket);
  // Does the same with other events, and beats that are comments.
  StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event);
  StatusFeed(const StatusFeed&) = delete;
  StatusFeed& operator=(const StatusFeed&) = delete;

  // True if one more page can be served.
  [[nodiscard]] bool has_room() const { return pages_.size() < kMostPages; }
  // Answers the request with a stream of events, which ends at the next event or beat after `may_go_on` has
  // become false; no status is sent from then on.
  void serve(
      const std::shared_ptr<HttpRequest>& request, MayGoOn may_go_on = [] { return true; });

 private:
  class Page;

  StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event, std::string beat);

  void tell(const StatusWatch::Json& status);
  void publish(std::string event);
  void beat();
  void wake_pages();

  EventLoop& loop_;
  Event event_of_;
  std::string beat_;
  StatusWatch watch_;
  std::set<Page*> pages_;  // owned by their requests
  std::string event_;      // the latest
  std::uint64_t version_ = 0, beats_ = 0;
  EventLoop::SourcePtr beat_timer_;
};

}  // namespace contourd::web
