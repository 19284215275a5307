// Runs other programs, and this program as its own child, for the benchmark. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace contourd::bench {

struct ProcessResult {
  double wall_s = 0;
  double cpu_s = 0;    // user and system time of all threads
  std::string output;  // standard output and error
};

// Runs a program to its end; blocks. Throws std::runtime_error if it cannot be started or fails.
[[nodiscard]] ProcessResult run_process(const std::vector<std::string>& command);

// Returns the program's path, found on PATH; nullopt if it is not there.
[[nodiscard]] std::optional<std::filesystem::path> find_program(const std::string& name);

// Returns the path of this program's executable.
[[nodiscard]] std::filesystem::path this_program();

// Returns the peak memory of this process since its start, in bytes (VmHWM). getrusage()'s ru_maxrss would
// not do: it starts from the parent's usage.
[[nodiscard]] double peak_memory_bytes();

}  // namespace contourd::bench
