// The project's pages, which are Markdown, as plain text for a terminal or a pipe. Knows what those pages
// use: headings, paragraphs, lists, tables, indented and fenced code, links, code spans and bold words.
// Thread-safe after the first call.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace contourd::ctl {

// Without marks and links' targets, in one line.
[[nodiscard]] std::string plain_words(std::string_view markdown);

// Lines of at most so many columns, but for what must stay whole: commands and long words are not broken.
// Ends with a line break.
[[nodiscard]] std::string plain_text(std::string_view markdown, std::size_t columns);

}  // namespace contourd::ctl
