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

  // Connects to contourd's control socket when the first page is open.
  StatusFeed(EventLoop& loop, const std::filesystem::path& socket, Event event = plain_event);
  StatusFeed(const StatusFeed&) = delete;
  StatusFeed& operator=(const StatusFeed&) = delete;

  // True if one more page can be served.
  [[nodiscard]] bool has_room() const { return pages_.size() < kMostPages; }
  // Answers the request with an endless stream of events.
  void serve(const std::shared_ptr<HttpRequest>& request);

 private:
  class Page;

  [[nodiscard]] static std::string plain_event(const StatusWatch::Json& status);

  void tell(const StatusWatch::Json& status);
  void publish(std::string event);
  void beat();
  void wake_pages();

  EventLoop& loop_;
  Event event_of_;
  StatusWatch watch_;
  std::set<Page*> pages_;  // owned by their requests
  std::string event_;      // the latest
  std::uint64_t version_ = 0, beats_ = 0;
  EventLoop::SourcePtr beat_timer_;
};

}  // namespace contourd::web
