// Pixels represented by their centres: at 0.5, 1.5, 2.5... Pure; thread-safe.
#pragma once

#include <cstdint>

namespace contourd {

// Returns how many centres lie before a number, up to a limit.
[[nodiscard]] inline std::int32_t centers_before(double number, std::int32_t limit) {
  double held = number > 0 ? number : 0;
  held = held < limit ? held : limit;
  const auto whole = static_cast<std::int32_t>(held);
  return whole + static_cast<std::int32_t>(held - whole > 0.5);
}

}  // namespace contourd
