#include "daemon/web/web_config.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>

#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/web/web_texts.hpp"

namespace contourd::web {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kBytesOfMebibyte = std::uint64_t{1} << 20U;

JsonDocument document_of(const fs::path& file) {
  std::error_code ignored;
  if (file == kDefaultWebConfig && !fs::exists(file, ignored))
    return JsonDocument::from_text("{}", file.string());
  return JsonDocument::from_file(file);
}

// Returns the address as HttpRequest::peer() has it; nullopt if the text is no address of a single computer.
std::optional<std::string> address_in(const std::string& text) {
  in6_addr six{};
  std::array<char, INET6_ADDRSTRLEN> written{};
  // An IPv4 address is the end of an IPv6 one.
  const bool is_four = text.find(':') == std::string::npos;
  const std::string mapped = is_four ? "::ffff:" + text : text;
  if (::inet_pton(AF_INET6, mapped.c_str(), &six) != 1) return std::nullopt;
  if (!IN6_IS_ADDR_V4MAPPED(&six)) {
    if (IN6_IS_ADDR_UNSPECIFIED(&six) || IN6_IS_ADDR_MULTICAST(&six)) return std::nullopt;
    return ::inet_ntop(AF_INET6, &six, written.data(), written.size());
  }
  constexpr std::uint8_t kFirstMulticast = 224;
  const std::uint8_t* const four = &six.s6_addr[12];
  if (four[0] == 0 || four[0] >= kFirstMulticast) return std::nullopt;
  return ::inet_ntop(AF_INET, four, written.data(), written.size());
}

std::optional<HostPort> host_port(const JsonSection& settings, const char* key) {
  if (!settings.has(key)) return std::nullopt;
  const JsonSection section = settings.section(key);
  HostPort host{.port = section.integer<int>("port"), .clients = section.texts("clients")};
  for (std::string& client : host.clients) {
    const std::optional<std::string> address = address_in(client);
    if (!address)
      section.reject("clients", fmt::format("{} is no address: give that of a computer, such as 192.168.1.30",
                                            in_quotes(client)));
    client = *address;
  }
  return host;
}

}  // namespace

WebConfig load_web_config(const fs::path& file) {
  JsonDocument document = document_of(file);
  JsonSchema(web_schema_text, "web.schema.json").check(document);
  document.throw_if_violated();
  const JsonSection section(document);
  WebConfig config{
      .control_socket = resolved(folder_of(file), section.text("control_socket")),
      .names = section.texts("names"),
      .session = std::chrono::hours(section.integer<int>("session_hours")),
      .largest_upload_bytes = section.integer<std::uint64_t>("largest_upload_mb") * kBytesOfMebibyte,
      .min_free_disk_bytes = section.integer<std::uint64_t>("min_free_disk_mb") * kBytesOfMebibyte,
      .nanodlp = host_port(section, "nanodlp"),
      .odyssey = host_port(section, "odyssey")};
  if (config.nanodlp && config.odyssey && config.nanodlp->port == config.odyssey->port)
    section.reject("odyssey",
                   fmt::format("nanodlp has the port {}, too: choose another", config.odyssey->port));
  for (std::string& name : config.names)
    std::ranges::transform(name, name.begin(), [](char letter) {
      return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
    });
  return config;
}

}  // namespace contourd::web
