#include "daemon/web/announcement.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "daemon/web/listen_sockets.hpp"
#include "daemon/web/setup/setting_file.hpp"

namespace contourd::web {
namespace {

// Returns host and port of an ADDRESS:PORT; both are empty if only this computer can reach it.
std::pair<std::string, std::string> reachable(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  const std::string host = address.substr(0, colon);
  if (colon == std::string::npos || host.starts_with("127.") || host == "[::1]") return {};
  return {host, address.substr(colon + 1)};
}

}  // namespace

std::vector<std::string> pages_at(const std::vector<std::string>& addresses) {
  std::vector<std::string> pages;
  for (const std::string& address : addresses) {
    auto [host, port] = reachable(address);
    if (host.empty()) continue;
    const std::vector<std::string> names = own_names();
    if ((host == "0.0.0.0" || host == "[::]") && !names.empty()) host = names.back() + ".local";
    pages.push_back(fmt::format("http://{}{}{}/", host, port == "80" ? "" : ":", port == "80" ? "" : port));
  }
  return pages;
}

std::string announcement_of(const std::vector<std::string>& addresses) {
  std::set<std::string> ports;
  for (const std::string& address : addresses)
    if (const std::string port = reachable(address).second; !port.empty()) ports.insert(port);
  if (ports.empty()) return "";
  std::string text =
      "<?xml version=\"1.0\" standalone=\"no\"?>\n"
      "<!DOCTYPE service-group SYSTEM \"avahi-service.dtd\">\n"
      "<!-- Written by contourctl web. -->\n"
      "<service-group>\n"
      "  <name replace-wildcards=\"yes\">contourd on %h</name>\n";
  for (const std::string& port : ports)
    text += fmt::format(
        "  <service>\n    <type>_http._tcp</type>\n    <port>{}</port>\n"
        "    <txt-record>path=/</txt-record>\n  </service>\n",
        port);
  return text + "</service-group>\n";
}

void announce(const std::vector<std::string>& addresses, const std::filesystem::path& file) {
  const std::string text = announcement_of(addresses);
  if (text.empty()) return remove_setting(file);
  write_setting(file, text);
}

}  // namespace contourd::web
