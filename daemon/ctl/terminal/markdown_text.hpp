// Renders the project's Markdown pages as plain text for a terminal or a pipe. Supports the elements that the
// pages use: headings, paragraphs, lists, tables, indented and fenced code, links, code spans and bold words.
// Thread-safe after the first call.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace contourd::ctl {

// Returns the text in one line, without markup and link targets.
[[nodiscard]] std::string plain_words(std::string_view markdown);

// Returns lines of at most `columns` columns, except that commands and long words are not broken. Ends with a
// line break.
[[nodiscard]] std::string plain_text(std::string_view markdown, std::size_t columns);

}  // namespace contourd::ctl
