// A time that the test sets; global because StepEngine and AxisInputs take a plain function as their clock.
#pragma once

#include "hw/clock.hpp"

namespace contourd::testing {

inline TimePoint test_time{};
inline TimePoint test_now() noexcept {
  return test_time;
}

}  // namespace contourd::testing
