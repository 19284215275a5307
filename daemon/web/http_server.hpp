// An HTTP/1.1 server (libmicrohttpd) on the event loop. It bounds the number of its clients, the size of
// their headers and the time of each request: a client that is too slow, or silent, is cut off. If there are
// too many, those that have not logged in go first. Event loop's thread only.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/web/http_request.hpp"
#include "hw/file_descriptor.hpp"

struct MHD_Daemon;

namespace contourd::web {

class HttpServer final : public HttpLoop {
 public:
  using Handler = std::function<void(const std::shared_ptr<HttpRequest>&)>;

  static constexpr std::size_t kMostClients = 64;
  // The time for the headers of a request, from the connection or the previous reply on.
  static constexpr std::chrono::seconds kHeaderTime{10};
  static constexpr std::size_t kMostHeaderBytes = 32768;

  // Serves the clients of these listening sockets. `handler` is called when a request's headers have arrived:
  // it answers the request, or has its body received. Throws std::runtime_error.
  HttpServer(EventLoop& loop, std::vector<FileDescriptor> listeners, Handler handler);
  ~HttpServer() override;
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Returns the number of connections.
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }

 private:
  struct Callbacks;

  void accept_clients(int listener);
  void rest(int listener);
  [[nodiscard]] bool make_room();
  void run();
  void run_soon() override;
  void run_at(TimePoint when);
  void cut_slow_clients();
  void look_at_clients_later();

  EventLoop& loop_;
  Handler handler_;
  MHD_Daemon* daemon_ = nullptr;
  std::vector<FileDescriptor> listeners_;
  std::map<int, std::unique_ptr<EventLoop::IoSource>> listener_sources_;
  EventLoop::SourcePtr epoll_source_, run_timer_, slow_timer_, rest_timer_;
  std::set<HttpClient*> clients_;      // owned by their connections
  std::set<HttpRequest*> unfinished_;  // owned by their connections
};

}  // namespace contourd::web
