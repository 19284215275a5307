// The file with the answers and checks of contourctl setup. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "daemon/ctl/setup/setup_questions.hpp"

namespace contourd::ctl {

struct SetupRecord {
  Answers answers;
  std::map<std::string, std::string> checks;  // outcome by the name of the check
};

// Reads a JSON object of answers, with an optional member "checks". Throws ConfigError with all mistakes,
// including unknown keys.
[[nodiscard]] SetupRecord read_setup_record(const std::filesystem::path& file);
// Writes the record; blocks until it is on disk. Throws std::system_error.
void write_setup_record(const std::filesystem::path& file, const SetupRecord& record);

}  // namespace contourd::ctl
