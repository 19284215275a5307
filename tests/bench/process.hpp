// Runs other programs, and this one again, for the benchmark. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::bench {

struct ProcessResult {
  double wall_s = 0;
  double cpu_s = 0;    // user and system, all its threads
  std::string output;  // standard output and error
};

// Runs a program to its end; blocks. Throws std::runtime_error when it cannot be started or fails.
[[nodiscard]] ProcessResult run_process(const std::vector<std::string>& command);

// The program's place on PATH, if it is there.
[[nodiscard]] std::optional<std::filesystem::path> find_program(const std::string& name);

// This program's own file.
[[nodiscard]] std::filesystem::path this_program();

// The most memory that this process has had in use at once since it was started, in bytes (VmHWM).
// getrusage()'s ru_maxrss will not do: it begins with what the parent had in use.
[[nodiscard]] double peak_memory_bytes();

}  // namespace contourd::bench
