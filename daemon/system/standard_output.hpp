// Checks that what a program prints has arrived: the last step of every program that prints something.
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

// Calls `run` and returns its exit code. Throws OutputError when not all that was printed to stdout has
// arrived (a full disk, a closed descriptor), whatever else came of it; and else what `run` throws.
int print_whole(const std::function<int()>& run);

}  // namespace contourd
