// Widths of text in a terminal, where a character takes zero, one or two columns. For printable UTF-8 (see
// daemon/system/readable.hpp). Thread-safe after the first call.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace contourd::ctl {

[[nodiscard]] std::size_t columns_of(std::string_view text);

// Cuts the text to at most `columns` columns; the cut is marked by "..." if there is room.
[[nodiscard]] std::string cut_to_columns(std::string_view text, std::size_t columns);

// Wraps the text into lines of at most `columns` columns, at spaces, or anywhere in a wider word. Returns at
// least one line. A character that is wider than `columns` is left out.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

}  // namespace contourd::ctl
