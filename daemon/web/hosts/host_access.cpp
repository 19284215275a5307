#include "daemon/web/hosts/host_access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "daemon/system/readable.hpp"
#include "daemon/web/request_checks.hpp"

namespace contourd::web {

std::string why_no_client(const HostCaller& caller, const HostAccess& access) {
  constexpr std::size_t kMostShown = 100;
  if (std::ranges::find(access.clients, caller.peer) == access.clients.end())
    return fmt::format("{} may not use this port: its clients are listed in /etc/contourd/web.json",
                       caller.peer.empty() ? "this computer" : caller.peer);
  if (!is_own_host(host_of(caller.host), caller.local, access.names))
    return fmt::format(
        "{}: not a name or an address of this printer; further names belong in \"names\" of "
        "/etc/contourd/web.json",
        caller.host.empty() ? "no Host" : printable(shortened(caller.host, kMostShown)));
  if (!caller.origin.empty() || !caller.sec_fetch_site.empty() || !caller.referer.empty() ||
      !caller.accept_language.empty() || caller.user_agent.starts_with("Mozilla/"))
    return "this port is for slicers and not for a browser: open the printer's page";
  return "";
}

HttpServer::Handler for_clients_only(HostAccess access, HttpServer::Handler handler) {
  return [access = std::move(access),
          handler = std::move(handler)](const std::shared_ptr<HttpRequest>& request) {
    const std::string why = why_no_client({.peer = request->peer(),
                                           .local = request->local(),
                                           .host = request->header("Host"),
                                           .origin = request->header("Origin"),
                                           .sec_fetch_site = request->header("Sec-Fetch-Site"),
                                           .referer = request->header("Referer"),
                                           .user_agent = request->header("User-Agent"),
                                           .accept_language = request->header("Accept-Language")},
                                          access);
    if (!why.empty()) return request->answer({.status = 403, .body = why + "\n"});
    request->has_logged_in();
    handler(request);
  };
}

}  // namespace contourd::web
