// Decodes and validates UTF-8 (Unicode, table 3-7); file names may contain other bytes. Pure functions,
// thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// True if this byte is a continuation byte of a character.
[[nodiscard]] bool continues_character(char byte);

// Returns the length in bytes of the well-formed character at the text's start; 0 if there is none.
[[nodiscard]] std::size_t utf_8_length(std::string_view text);

// Returns the offset of the first byte that is not part of a well-formed character.
[[nodiscard]] std::optional<std::size_t> first_invalid_utf_8(std::string_view text);

// Returns the longest start of the text that has at most `bytes` bytes and does not end within a character.
[[nodiscard]] std::string_view cut_utf_8(std::string_view text, std::size_t bytes);

// Returns the Unicode code point of a character. REQUIRES: `character` is exactly one well-formed character.
[[nodiscard]] char32_t code_point(std::string_view character);

// Returns the code points of all characters, with U+FFFD for each byte that is not part of one.
[[nodiscard]] std::u32string code_points(std::string_view text);

}  // namespace contourd
