// What a fuzz target holds to be true: where it is not, the target ends as by a crash. Thread-safe.
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
