// Checks that all output of a program was written; every program that prints something runs through this
// check.
#pragma once

#include <functional>
#include <stdexcept>

namespace contourd {

// Exit codes of both programs, from BSD's sysexits.h.
inline constexpr int kBadUsage = 64;      // EX_USAGE: the command line cannot be used
inline constexpr int kCannotCreate = 73;  // EX_CANTCREAT: an output cannot be written

struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Calls `run` and returns its exit code. Throws OutputError if some of stdout could not be written (a full
// disk, a closed descriptor), whether or not `run` succeeded; otherwise passes on the exceptions of `run`.
int print_whole(const std::function<int()>& run);

}  // namespace contourd
