// NanoDLP's interface, as far as DragonFruit and Orion need it to print: most requests are GET, and act.
// Event loop's thread only.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/web/hosts/host_access.hpp"
#include "daemon/web/hosts/host_printer.hpp"
#include "daemon/web/http_server.hpp"

namespace contourd::web {

class NanodlpHost {
 public:
  // Serves the clients of these listening sockets. The printer must outlive the object. `version` is
  // contourd's. Throws std::runtime_error.
  NanodlpHost(EventLoop& loop, HostPrinter& printer, HostAccess access, std::string version,
              std::vector<FileDescriptor> listeners);

 private:
  using RequestPtr = std::shared_ptr<HttpRequest>;

  void serve(const RequestPtr& request);
  void serve_get(const RequestPtr& request);
  void serve_command(const RequestPtr& request, std::string_view command);
  void serve_picture(const RequestPtr& request, std::string_view place);
  void serve_machine(const RequestPtr& request);

  std::string version_;
  HostPrinter& printer_;
  HttpServer server_;  // last: its requests refer to the others
};

}  // namespace contourd::web
