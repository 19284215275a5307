// Text of which nobody knows what is in it (names of files, what a file says), made fit for a person. Every
// way out to one goes through here. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace contourd {

// At most so many bytes, never half a character; what is left out is said: "... (1,940 bytes more)".
[[nodiscard]] std::string shortened(std::string_view text, std::size_t bytes);

// Fit for a terminal, the log or a page, whatever bytes it was made of: valid UTF-8 in one line. Control
// characters become '?', and so does what changes the direction of writing or is not seen at all.
[[nodiscard]] std::string printable(std::string_view text);
// The same, but its line breaks stay.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace contourd
