// The settings of the web page, in web.json. A value.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace contourd::web {

struct WebConfig {
  std::filesystem::path control_socket;
  std::vector<std::string> names;  // further names under which people reach this computer, in lower case
  std::chrono::hours session{};
  std::uint64_t largest_upload_bytes = 0;
  std::uint64_t min_free_disk_bytes = 0;
};

inline constexpr const char* kDefaultWebConfig = "/etc/contourd/web.json";

// Reads the file; the default file may be missing, which means the schema's defaults. Throws ConfigError.
[[nodiscard]] WebConfig load_web_config(const std::filesystem::path& file);

}  // namespace contourd::web
