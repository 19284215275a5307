// Access to the ports for clients of other print hosts' interfaces, which cannot log in: only listed
// computers, and no browser on them. Thread-safe (no state).
#pragma once

#include <string>
#include <vector>

#include "daemon/web/http_server.hpp"

namespace contourd::web {

struct HostAccess {
  std::vector<std::string> clients;  // addresses of the only clients
  std::vector<std::string> names;    // of this computer, as is_own_host() takes them
};

// The client of a request, and the headers that tell where the request comes from; empty if absent.
struct HostCaller {
  std::string peer, local;  // as of HttpRequest
  std::string host;
  std::string origin{}, sec_fetch_site{}, referer{}, user_agent{}, accept_language{};
};

// Returns why the caller may not use the port, a sentence; empty if it may. A browser is refused, since a
// page of any site can have it send a GET request, which these interfaces act on: on plain HTTP it need not
// say where such a request comes from, but it always says which language it prefers.
[[nodiscard]] std::string why_no_client(const HostCaller& caller, const HostAccess& access);

// Returns a handler that answers requests of others with the reason (403), and passes on those of clients.
[[nodiscard]] HttpServer::Handler for_clients_only(HostAccess access, HttpServer::Handler handler);

}  // namespace contourd::web
