#include "daemon/ctl/terminal/text_columns.hpp"

#include <algorithm>
#include <clocale>
#include <cwchar>

#include "core/contract/expects.hpp"

namespace contourd::ctl {
namespace {

// Selects UTF-8, because names are UTF-8 in any locale.
void use_utf_8() {
  static const bool used = std::setlocale(LC_CTYPE, "C.UTF-8") != nullptr;
  (void)used;
}

struct Character {
  std::string_view bytes;
  std::size_t columns;
};

// Returns the first character; an invalid byte counts as one character. REQUIRES: the text is not empty.
Character first_character(std::string_view text) {
  expects(!text.empty(), "a text has a first character");
  use_utf_8();
  std::mbstate_t state{};
  wchar_t character = 0;
  const std::size_t read = std::mbrtowc(&character, text.data(), text.size(), &state);
  const bool is_one = read > 0 && read <= text.size();  // false: mbrtowc() returned an error
  const int columns = is_one ? ::wcwidth(character) : 1;
  return {text.substr(0, is_one ? read : 1), static_cast<std::size_t>(columns < 0 ? 1 : columns)};
}

// Returns the longest beginning of the text that fits into the columns.
std::string_view beginning(std::string_view text, std::size_t columns) {
  std::size_t used = 0, end = 0;
  while (end < text.size()) {
    const Character next = first_character(text.substr(end));
    if (used + next.columns > columns) break;
    used += next.columns;
    end += next.bytes.size();
  }
  return text.substr(0, end);
}

}  // namespace

std::size_t columns_of(std::string_view text) {
  std::size_t columns = 0;
  while (!text.empty()) {
    const Character next = first_character(text);
    columns += next.columns;
    text.remove_prefix(next.bytes.size());
  }
  return columns;
}

std::string cut_to_columns(std::string_view text, std::size_t columns) {
  constexpr std::string_view kMore = "...";
  if (columns_of(text) <= columns) return std::string(text);
  if (columns < 2 * kMore.size()) return std::string(beginning(text, columns));
  return std::string(beginning(text, columns - kMore.size())).append(kMore);
}

std::vector<std::string> wrapped(std::string_view text, std::size_t columns) {
  std::vector<std::string> lines;
  while (columns_of(text) > columns) {
    std::string_view line = beginning(text, columns);
    if (line.empty()) {
      text.remove_prefix(first_character(text).bytes.size());
      continue;
    }
    const bool between_words = text[line.size()] == ' ';
    const std::size_t space = line.rfind(' ');
    if (!between_words && space != std::string_view::npos && space > 0) line = line.substr(0, space);
    lines.emplace_back(line);
    text.remove_prefix(line.size());
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  }
  if (!text.empty() || lines.empty()) lines.emplace_back(text);
  return lines;
}

}  // namespace contourd::ctl
