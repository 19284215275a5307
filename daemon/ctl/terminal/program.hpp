// Runs other programs, which are found by PATH, without a shell. Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace contourd::ctl {

struct ProgramOutput {
  std::string text;  // standard output of the program
  int code = 0;      // exit code; 128 + number of the signal that killed the program
};

// Runs a program until it ends or has printed `most_bytes`; its standard error is discarded. `words` begin
// with the program's name. Throws std::system_error if it cannot be started.
[[nodiscard]] ProgramOutput run_program(const std::vector<std::string>& words, std::size_t most_bytes);

// Replaces this process by the program (exec). Throws std::system_error if that fails.
[[noreturn]] void become_program(const std::vector<std::string>& words);

}  // namespace contourd::ctl
