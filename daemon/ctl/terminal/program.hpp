// Other programs that contourctl runs; found by PATH, and by no shell. Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace contourd::ctl {

struct ProgramOutput {
  std::string text;  // of its standard output
  int code = 0;      // its exit code; above 128 of one that a signal ended
};

// Runs it to its end, or until it has printed so much. What it says on its standard error is not seen.
// `words` begin with its name. Throws std::system_error when it cannot be started.
[[nodiscard]] ProgramOutput run_program(const std::vector<std::string>& words, std::size_t most_bytes);

// This process goes on as that program. Throws std::system_error when it cannot.
[[noreturn]] void become_program(const std::vector<std::string>& words);

}  // namespace contourd::ctl
