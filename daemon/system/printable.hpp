// Makes text from untrusted sources (names and contents of files) safe to show. All text that reaches a
// person goes through these functions. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace contourd {

// Returns at most `bytes` bytes of the text, never part of a character, followed by the length of the rest:
// "... (1940 bytes more)".
[[nodiscard]] std::string shortened(std::string_view text, std::size_t bytes);

// Returns the text as one line of valid UTF-8, safe for a terminal, the log or a page. Control characters,
// invisible characters and those that change the writing direction become '?'.
[[nodiscard]] std::string printable(std::string_view text);
// Does the same, but keeps line breaks.
[[nodiscard]] std::string printable_lines(std::string_view text);

}  // namespace contourd
