// Folders and files for the tests of what an owner edits. Not thread-safe.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "daemon/config/config_error.hpp"

namespace contourd::testing {

// A new folder; removed with everything in it at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "contourd-config-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::filesystem::path& name, std::string_view text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  std::filesystem::path write_json(const std::filesystem::path& name, const nlohmann::json& value) const {
    return write(name, value.dump(2));
  }

 private:
  std::filesystem::path path_;
};

// What the call throws as ConfigError; empty when it throws none.
template <typename Call>
std::vector<Violation> violations_of(Call call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.violations();
  }
  return {};
}

// The same as `pointer: message`, or the message alone for the whole file.
template <typename Call>
std::vector<std::string> complaints_of(Call call) {
  std::vector<std::string> complaints;
  for (const Violation& violation : violations_of(call)) {
    complaints.push_back(violation.pointer.empty() ? violation.message
                                                   : violation.pointer + ": " + violation.message);
  }
  return complaints;
}

using Complaints = std::vector<std::string>;

inline nlohmann::json shipped(const std::string& name) {
  std::ifstream stream(std::filesystem::path(CONTOURD_CONFIG_DIR) / name);
  return nlohmann::json::parse(stream);
}

}  // namespace contourd::testing
