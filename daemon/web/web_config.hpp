// The settings of the web page, in web.json. A value.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::web {

// A port for clients of another print host's interface, which cannot log in.
struct HostPort {
  int port = 0;
  std::vector<std::string> clients;  // addresses of the only clients, as HttpRequest::peer() writes them
};

struct WebConfig {
  std::filesystem::path control_socket;
  std::vector<std::string> names;  // further names under which people reach this computer, in lower case
  std::chrono::hours session{};
  std::uint64_t largest_upload_bytes = 0;
  std::uint64_t min_free_disk_bytes = 0;
  std::optional<HostPort> nanodlp{}, odyssey{};  // nullopt: off
};

inline constexpr const char* kDefaultWebConfig = "/etc/contourd/web.json";

// Reads the file; the default file may be missing, which means the schema's defaults. Throws ConfigError.
[[nodiscard]] WebConfig load_web_config(const std::filesystem::path& file);

}  // namespace contourd::web
