// Values as a person reads them. Thread-safe (no shared state).
#pragma once

#include <string>
#include <string_view>

#include "hw/clock.hpp"

namespace contourd {

// "3 h 05 min", "12 min 30 s", "4.2 s".
[[nodiscard]] std::string readable(Duration duration);

// Valid UTF-8 in one line: control characters and broken sequences (file names may hold any byte) become '?'.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace contourd
