// Formats values for people, and makes text from untrusted sources (names and contents of files) safe to
// show. All text that reaches a person goes through printable(). Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <ratio>
#include <string>
#include <string_view>

#include "hw/clock.hpp"

namespace contourd {

// Returns at most `bytes` bytes of the text, never part of a character, followed by the length of the rest:
// "... (1940 bytes more)".
[[nodiscard]] std::string shortened(std::string_view text, std::size_t bytes);

// Returns the text as one line of valid UTF-8, safe for a terminal, the log or a page. Control characters,
// invisible characters and those that change the writing direction become '?'.
[[nodiscard]] std::string printable(std::string_view text);
// Does the same, but keeps line breaks.
[[nodiscard]] std::string printable_lines(std::string_view text);

// Returns "3 h 05 min", "12 min 30 s" or "4.2 s".
[[nodiscard]] std::string readable(Duration duration);
// Returns "1 layer" or "2 layers".
[[nodiscard]] std::string count_of(std::uint64_t count, std::string_view one, std::string_view many);
// Returns coordinates, such as "12.30, 0.00, -4.25". One that is rounded to zero has no sign.
[[nodiscard]] std::string coordinates(std::initializer_list<double> mm, int decimals = 2);
// Returns the time in UTC: "2026-11-20T19:05:00Z".
[[nodiscard]] std::string iso_time(std::chrono::system_clock::time_point time);
// Returns the time in the time zone of this process, with its offset from UTC: "2026-11-20 20:05:00 +0100".
[[nodiscard]] std::string local_time(std::chrono::system_clock::time_point time);
// Returns the duration in milliseconds, with fractions.
[[nodiscard]] inline double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace contourd
