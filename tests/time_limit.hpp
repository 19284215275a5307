// The longest real time that a test waits for a condition.
#pragma once

#include <chrono>

namespace contourd::testing {

// Far longer than any wait on an idle machine, because a disk that stalls has held up tests for 20 s. Below
// ctest's timeout of a unit test (tests/CMakeLists.txt), so that the failed test says which condition it
// waited for. Sanitizers make code up to fifty times slower.
#ifdef CONTOURD_COSTLY_CHECKS
inline constexpr std::chrono::seconds kTimeLimit{800};
#else
inline constexpr std::chrono::seconds kTimeLimit{100};
#endif

}  // namespace contourd::testing
