// Checks of a request's headers and names, all of which come from strangers. Thread-safe (no state).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace contourd::web {

// Returns the host of a Host header in lower case, without its port and without the brackets of an IPv6
// address; empty if the header is no host.
[[nodiscard]] std::string host_of(std::string_view header);

// True if the host is a name of this computer: the address at which the client reached it, localhost if that
// is a loopback address, or one of `names`, in lower case, alone or as NAME.local. A page of another site
// that makes its own name point to this computer (DNS rebinding) names another host.
[[nodiscard]] bool is_own_host(std::string_view host, std::string_view local_address,
                               const std::vector<std::string>& names);

// The headers by which a browser says where a request comes from; empty if absent.
struct RequestOrigin {
  std::string host;            // Host
  std::string origin;          // Origin
  std::string sec_fetch_site;  // Sec-Fetch-Site
};
// True if a page of another site, or of another port of this computer, made the browser send the request.
[[nodiscard]] bool is_cross_site(const RequestOrigin& origin);

// Returns the value of a cookie in a Cookie header; empty if there is none.
[[nodiscard]] std::string cookie_of(std::string_view header, std::string_view name);

// Returns a sentence about a name that cannot be the name of a model in the spool; empty for a good one.
[[nodiscard]] std::string why_bad_file_name(const std::string& name);

}  // namespace contourd::web
