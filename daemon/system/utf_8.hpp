// UTF-8 (Unicode, table 3-7), which names of files need not be. Pure functions, thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

// Whether this byte goes on with a character that another one began.
[[nodiscard]] bool continues_character(char byte);

// Of bytes: of the well-formed character at the text's start; 0 if there is none.
[[nodiscard]] std::size_t utf_8_length(std::string_view text);

// The offset in bytes of the first one that is part of no well-formed character.
[[nodiscard]] std::optional<std::size_t> first_invalid_utf_8(std::string_view text);

// At most so many bytes of it, never half a character.
[[nodiscard]] std::string_view cut_utf_8(std::string_view text, std::size_t bytes);

// Unicode's number of a character. REQUIRES: one that is well-formed, and nothing else.
[[nodiscard]] char32_t code_point(std::string_view character);

// The same of all characters; U+FFFD for a byte that is part of none.
[[nodiscard]] std::u32string code_points(std::string_view text);

}  // namespace contourd
