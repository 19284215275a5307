// The allocations of work that is repeated, once it has seen its largest input.
#pragma once

#include "tests/allocation_counter.hpp"

namespace contourd::testing {

// Makes the call `passes` times and returns the allocations of the last one.
template <typename Call>
long allocations_when_warm(int passes, Call call) {
  for (int pass = 1; pass < passes; ++pass)
    call();
  const long before = allocations();
  call();
  return allocations() - before;
}

}  // namespace contourd::testing
