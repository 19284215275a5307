// The file that keeps what whoever brings a printer up has answered. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "daemon/ctl/setup/setup_answers.hpp"

namespace contourd::ctl {

// What the questions have led to, and what has become of each check.
struct SetupRecord {
  Answers answers;
  std::map<std::string, std::string> checks;
};

// A JSON object of answers, with "checks" in it where some were made. Throws ConfigError with all that is
// wrong with it, a key that is no question's too.
[[nodiscard]] SetupRecord read_setup_record(const std::filesystem::path& file);
// Blocks until the disk has it. Throws std::system_error.
void write_setup_record(const std::filesystem::path& file, const SetupRecord& record);

}  // namespace contourd::ctl
