// The longest real time that a test waits for a condition.
#pragma once

#include <chrono>

namespace contourd::testing {

// Far longer than any wait on an idle machine, because a disk that stalls has held up tests for 20 s. Below
// ctest's timeout of a unit test (tests/CMakeLists.txt), so that the failed test says which condition it
// waited for.
inline constexpr std::chrono::seconds kTimeLimit{100};

}  // namespace contourd::testing
