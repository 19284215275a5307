// Counts this program's memory allocations: replaces its operator new by one that counts. Link
// allocation_counter. Thread-safe.
#pragma once

namespace contourd::testing {

// Returns the number of allocations since the program's start, in all threads.
[[nodiscard]] long allocations();

}  // namespace contourd::testing
