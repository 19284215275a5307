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

// Returns the address as the kernel writes it; nullopt if the text is no address.
std::optional<std::string> address_in(const std::string& text) {
  std::array<std::uint8_t, sizeof(in6_addr)> bytes{};
  std::array<char, INET6_ADDRSTRLEN> written{};
  const int family = text.find(':') == std::string::npos ? AF_INET : AF_INET6;
  if (::inet_pton(family, text.c_str(), bytes.data()) != 1) return std::nullopt;
  if (::inet_ntop(family, bytes.data(), written.data(), written.size()) == nullptr) return std::nullopt;
  return written.data();
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
