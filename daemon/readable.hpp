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

// Fit for a terminal, the log or a page, whatever bytes it was made of: valid UTF-8 in one line. Control
// characters become '?', and so does what changes the direction of writing or is not seen at all.
[[nodiscard]] std::string printable(std::string_view text);
// The same, but its line breaks stay.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace contourd
