// How often this program has taken memory: its operator new is replaced by one that counts. Link
// allocation_counter. Thread-safe.
#pragma once

namespace contourd::testing {

// Since the program's start, in all threads.
[[nodiscard]] long allocations();

}  // namespace contourd::testing
