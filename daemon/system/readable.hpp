// Formats values for people. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <cstdint>
#include <ratio>
#include <string>
#include <string_view>

#include "daemon/system/printable.hpp"  // IWYU pragma: export
#include "hw/clock.hpp"

namespace contourd {

// Returns "3 h 05 min", "12 min 30 s" or "4.2 s".
[[nodiscard]] std::string readable(Duration duration);
// Returns "1 layer" or "2 layers".
[[nodiscard]] std::string count_of(std::uint64_t count, std::string_view one, std::string_view many);
// Returns the time in UTC: "2026-11-20T19:05:00Z".
[[nodiscard]] std::string iso_time(std::chrono::system_clock::time_point time);
// Returns the duration in milliseconds, with fractions.
[[nodiscard]] inline double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace contourd
