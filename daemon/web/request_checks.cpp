#include "daemon/web/request_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "daemon/formats/model_names.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/utf_8.hpp"

namespace contourd::web {
namespace {

constexpr std::size_t kLongestHost = 255, kLongestName = 200;

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& letter : result)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return result;
}

bool is_port(std::string_view text) {
  return text.size() <= 5 && text.find_first_not_of("0123456789") == std::string_view::npos;
}

bool is_host_letter(char letter) {
  return (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9') || letter == '.' ||
         letter == '-' || letter == '_' || letter == ':';
}

// True for spaces of all widths, joiners, and letters without ink.
bool is_blank(char32_t c) {
  constexpr std::array<char32_t, 9> kBlanks{' ',    0xA0,   0x1680, 0x202F, 0x205F,
                                            0x2800, 0x3000, 0x3164, 0xFFA0};
  return std::ranges::find(kBlanks, c) != kBlanks.end() || (c >= 0x2000 && c <= 0x200D);
}

bool is_loopback(std::string_view address) {
  return address == "::1" || address.starts_with("127.");
}

}  // namespace

std::string host_of(std::string_view header) {
  if (header.size() > kLongestHost) return "";
  std::string host = lower(header);
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    if (end == std::string::npos) return "";
    const std::string_view rest = std::string_view(host).substr(end + 1);
    if (!rest.empty() && (rest.front() != ':' || !is_port(rest.substr(1)))) return "";
    host = host.substr(1, end - 1);
  } else if (const std::size_t colon = host.find(':'); colon != std::string::npos) {
    if (!is_port(std::string_view(host).substr(colon + 1))) return "";
    host.resize(colon);
  }
  if (host.ends_with('.')) host.pop_back();
  return std::ranges::all_of(host, is_host_letter) ? host : "";
}

bool is_own_host(std::string_view host, std::string_view local_address,
                 const std::vector<std::string>& names) {
  if (host.empty()) return false;
  if (host == local_address) return true;
  if (host == "localhost") return is_loopback(local_address);
  return std::ranges::any_of(
      names, [host](const std::string& name) { return host == name || host == name + ".local"; });
}

bool is_cross_site(const RequestOrigin& origin) {
  if (!origin.sec_fetch_site.empty() && origin.sec_fetch_site != "same-origin" &&
      origin.sec_fetch_site != "none")
    return true;
  if (origin.origin.empty()) return false;
  const std::size_t scheme = origin.origin.find("://");
  return scheme == std::string::npos || lower(origin.origin.substr(scheme + 3)) != lower(origin.host);
}

std::string cookie_of(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=')
      return std::string(pair.substr(name.size() + 1));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return "";
}

std::string why_bad_file_name(const std::string& name) {
  if (name.empty()) return "the file has no name";
  const std::string shown = printable(shortened(name, kLongestName));
  if (name.size() > kLongestName)
    return fmt::format("{}: the file's name is too long; at most {} bytes are possible", shown, kLongestName);
  if (name.find_first_of("/\\") != std::string::npos || name.front() == '.')
    return fmt::format("{}: a file's name has no slash, and does not begin with a dot", shown);
  if (printable(name) != name)
    return fmt::format("{}: the file's name has characters that cannot be shown; rename the file", shown);
  if (!is_model_name(name))
    return fmt::format("{}: this is no model that the printer can print, such as an STL file", shown);
  if (std::ranges::all_of(code_points(model_stem(name)), is_blank))
    return fmt::format("\"{}\": the file's name is blank before its extension; rename the file", shown);
  return "";
}

}  // namespace contourd::web
