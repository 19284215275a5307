// Comparison of lengths, areas and places, in whatever unit they are.
#pragma once

#include <cmath>

namespace contourd::testing {

// Tolerance for some hundred roundings of 2^-53 each, of numbers up to some thousand.
inline constexpr double kRounding = 1e-9;

inline bool near(double a, double b, double tolerance = kRounding) {
  return std::fabs(a - b) <= tolerance;
}

}  // namespace contourd::testing
