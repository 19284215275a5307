// A check of a fuzz target: if it fails, the target aborts as in a crash. Thread-safe.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace contourd::fuzz {

inline void demand(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

}  // namespace contourd::fuzz
