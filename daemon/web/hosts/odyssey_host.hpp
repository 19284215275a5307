// Odyssey's interface, as far as Orion needs it to print. Event loop's thread only.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/web/hosts/host_access.hpp"
#include "daemon/web/hosts/host_printer.hpp"
#include "daemon/web/http_server.hpp"
#include "daemon/web/status_feed.hpp"

namespace contourd::web {

class OdysseyHost {
 public:
  // Serves the clients of these listening sockets. The printer must outlive the object. `version` is
  // contourd's. Throws std::runtime_error.
  OdysseyHost(EventLoop& loop, HostPrinter& printer, HostAccess access, std::string version,
              std::vector<FileDescriptor> listeners);

 private:
  using RequestPtr = std::shared_ptr<HttpRequest>;

  void serve(const RequestPtr& request);
  void serve_get(const RequestPtr& request);
  void serve_post(const RequestPtr& request);
  void serve_events(const RequestPtr& request);
  void serve_files(const RequestPtr& request);
  void serve_config(const RequestPtr& request);
  void upload(const RequestPtr& request);

  std::string version_;
  HostPrinter& printer_;
  StatusFeed feed_;
  HttpServer server_;  // last: its requests refer to the others
};

}  // namespace contourd::web
