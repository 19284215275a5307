// The sentence with which a fit refuses measurements, and a limit that fits share.
#pragma once

#include <array>
#include <cstdio>

#include "core/calibration/line_fit.hpp"

namespace contourd {

inline constexpr double kThickestUm = 100'000;  // of cured resin; more is no measurement in um

// Throws CalibrationRefused with a sentence, written as by printf.
template <typename... Figures>
[[noreturn]] void refuse(const char* format, Figures... figures) {
  std::array<char, 400> text{};
  (void)std::snprintf(text.data(), text.size(), format, figures...);
  throw CalibrationRefused(text.data());
}

}  // namespace contourd
