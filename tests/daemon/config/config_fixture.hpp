// Helpers for tests of files that a user edits. Not thread-safe.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::testing {

// A temporary folder that can also write JSON values.
class ConfigFolder : public TemporaryFolder {
 public:
  std::filesystem::path write_json(const std::filesystem::path& name, const nlohmann::json& value) const {
    return write(name, value.dump(2));
  }
};

// Returns the violations of the ConfigError that the call throws; empty if it throws none.
template <typename Call>
std::vector<Violation> violations_of(Call call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.violations();
  }
  return {};
}

// Returns these violations as `pointer: message`, or only the message for the whole file.
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

// Reads a file of config/.
inline nlohmann::json shipped(const std::string& name) {
  std::ifstream stream(std::filesystem::path(CONTOURD_CONFIG_DIR) / name);
  return nlohmann::json::parse(stream);
}

}  // namespace contourd::testing
