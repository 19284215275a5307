// Values as a person reads them. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "hw/clock.hpp"

namespace contourd {

// "3 h 05 min", "12 min 30 s", "4.2 s".
[[nodiscard]] std::string readable(Duration duration);

// At most so many bytes, never half a character; what is left out is said: "... (1,940 bytes more)".
[[nodiscard]] std::string shortened(std::string_view text, std::size_t bytes);

// Valid UTF-8 in one line: control characters and broken sequences (file names may hold any byte) become '?'.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace contourd
