// Text as a terminal shows it: characters may take no column, one or two. For printable UTF-8 (see
// daemon/system/readable.hpp). Thread-safe after the first call.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace contourd::ctl {

[[nodiscard]] std::size_t columns_of(std::string_view text);

// Its beginning, in so many columns at most; what is left out is shown as "..." where there is room for that.
[[nodiscard]] std::string cut_to_columns(std::string_view text, std::size_t columns);

// Lines of so many columns at most, broken at spaces, or anywhere in a word that is wider. One line at least.
// A character that is wider than `columns` is left out.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

}  // namespace contourd::ctl
