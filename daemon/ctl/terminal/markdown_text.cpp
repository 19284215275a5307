#include "daemon/ctl/terminal/markdown_text.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <span>
#include <vector>

#include "daemon/ctl/terminal/text_columns.hpp"

namespace contourd::ctl {
namespace {

using Lines = std::vector<std::string>;
using Cells = std::vector<std::string>;

// Minimum width of a line; a narrower terminal breaks the lines itself.
constexpr std::size_t kNarrowest = 20;
constexpr std::size_t kCodeIndent = 4;

std::size_t leading_spaces(std::string_view line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(leading_spaces(text));
  while (!text.empty() && text.back() == ' ')
    text.remove_suffix(1);
  return text;
}

Lines lines_of(std::string_view text) {
  Lines lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Returns the length of the list marker ("- " or "1. ") at the start of the text, or 0.
std::size_t bullet_of(std::string_view text) {
  if (text.starts_with("- ")) return 2;
  std::size_t digits = 0;
  while (digits < text.size() && std::isdigit(static_cast<unsigned char>(text[digits])) != 0)
    ++digits;
  return digits > 0 && text.substr(digits).starts_with(". ") ? digits + 2 : 0;
}

bool is_code(std::string_view line) {
  return leading_spaces(line) >= kCodeIndent && leading_spaces(line) < line.size();
}

bool begins_block(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.empty() || text.starts_with('#') || text.starts_with('|') || text.starts_with("```") ||
         bullet_of(text) > 0;
}

Cells cells_of(std::string_view row) {
  Cells cells;
  std::string cell;
  row = trimmed(row);
  row.remove_prefix(1);
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row[i] == '\\' && i + 1 < row.size() && row[i + 1] == '|') {
      cell += row[++i];
    } else if (row[i] == '|') {
      cells.push_back(plain_words(cell));
      cell.clear();
    } else {
      cell += row[i];
    }
  }
  return cells;
}

bool is_rule(const Cells& cells) {
  return std::ranges::all_of(cells, [](const std::string& cell) {
    return !cell.empty() && cell.find_first_not_of("-: ") == std::string::npos;
  });
}

class Page {
 public:
  Page(std::string_view markdown, std::size_t columns)
      : lines_(lines_of(markdown)), columns_(std::max(columns, kNarrowest)) {}

  std::string text() {
    while (at_ < lines_.size())
      take_block();
    while (text_.ends_with("\n\n"))
      text_.pop_back();
    return text_;
  }

 private:
  void take_block() {
    const std::string& line = lines_[at_];
    const std::string_view text = trimmed(line);
    if (text.empty()) {
      ++at_;
      if (!text_.empty() && !text_.ends_with("\n\n")) text_ += '\n';
    } else if (text.starts_with("```")) {
      take_fence();
    } else if (text.starts_with('#')) {
      take_heading(text);
    } else if (text.starts_with('|')) {
      take_table();
    } else if (bullet_of(text) > 0) {
      take_item(text);
    } else if (is_code(line)) {
      take_code(line.substr(kCodeIndent));
      ++at_;
    } else {
      put("", "", paragraph());
    }
  }

  // Appends the words as wrapped lines: the first begins with `first`, the others with `indent`.
  void put(std::string first, const std::string& indent, const std::string& words) {
    const std::size_t room = std::max(columns_ - std::min(indent.size(), columns_), kNarrowest / 2);
    if (words.empty()) return;
    for (const std::string& line : wrapped(words, room)) {
      text_ += first + line + '\n';
      first = indent;
    }
  }

  // Consumes the current line and its continuation lines. Returns them as one paragraph.
  std::string paragraph() {
    std::string words(trimmed(lines_[at_++]));
    while (at_ < lines_.size() && !begins_block(lines_[at_]))
      words.append(" ").append(trimmed(lines_[at_++]));
    return plain_words(words);
  }

  void take_heading(std::string_view text) {
    const std::size_t level = std::min(text.find_first_not_of('#'), text.size());
    const std::string title = plain_words(trimmed(text.substr(level)));
    put("", "", title);
    if (level <= 2)
      text_ += std::string(std::min(columns_of(title), columns_), level == 1 ? '=' : '-') + '\n';
    ++at_;
  }

  void take_item(std::string_view text) {
    const std::size_t mark = bullet_of(text);
    const std::string before(leading_spaces(lines_[at_]), ' ');
    const std::string bullet(text.substr(0, mark));
    lines_[at_].erase(0, before.size() + mark);
    put(before + bullet, before + std::string(mark, ' '), paragraph());
  }

  void take_fence() {
    for (++at_; at_ < lines_.size() && !trimmed(lines_[at_]).starts_with("```"); ++at_)
      take_code(lines_[at_]);
    ++at_;
  }

  // Appends a line of code unchanged. If the line is too wide, its remark moves to a line above it.
  void take_code(std::string_view code) {
    const std::string indent(kCodeIndent, ' ');
    const std::size_t remark = code.find("  # ");
    if (columns_of(code) + kCodeIndent > columns_ && remark != std::string_view::npos && remark > 0) {
      const std::size_t words = code.find('#', remark) + 2;
      put(indent + "# ", indent + "# ", std::string(trimmed(code.substr(words))));
      code = trimmed(code.substr(0, remark));
    }
    text_ += trimmed(code).empty() ? "\n" : indent + std::string(code) + '\n';
  }

  void take_table() {
    std::vector<Cells> rows;
    while (at_ < lines_.size() && trimmed(lines_[at_]).starts_with('|')) {
      Cells cells = cells_of(lines_[at_++]);
      if (!cells.empty() && !is_rule(cells)) rows.push_back(std::move(cells));
    }
    if (!rows.empty()) put_table(rows.front(), std::span(rows).subspan(1));
  }

  static std::vector<std::size_t> widths_of(const Cells& names, std::span<const Cells> rows) {
    std::vector<std::size_t> widths;
    for (std::size_t i = 0; i < names.size(); ++i) {
      widths.push_back(columns_of(names[i]));
      for (const Cells& row : rows)
        if (i < row.size()) widths[i] = std::max(widths[i], columns_of(row[i]));
    }
    return widths;
  }

  void put_table(const Cells& names, std::span<const Cells> rows) {
    std::vector<std::size_t> widths = widths_of(names, rows);
    const std::size_t others =
        std::accumulate(widths.begin(), widths.end() - 1, std::size_t{0}) + kGap * (widths.size() - 1);
    // The last column gets the remaining width, if that is wide enough to read.
    if (others * 2 > columns_) return put_entries(names, rows);
    widths.back() = columns_ - others;
    put_row(names, widths);
    text_ += std::string(std::min(columns_, others + columns_of(names.back())), '-') + '\n';
    for (const Cells& row : rows)
      put_row(row, widths);
  }

  void put_row(const Cells& row, const std::vector<std::size_t>& widths) {
    std::string before;
    for (std::size_t i = 0; i + 1 < row.size() && i + 1 < widths.size(); ++i)
      before += row[i] + std::string(widths[i] + kGap - columns_of(row[i]), ' ');
    const std::string last = row.empty() ? "" : row.back();
    if (last.empty()) {
      text_ += std::string(trimmed(before)) + '\n';
    } else {
      put(before, std::string(columns_of(before), ' '), last);
    }
  }

  // Appends each row as an entry: the first cell, then a line for each other cell with its column's name.
  void put_entries(const Cells& names, std::span<const Cells> rows) {
    for (const Cells& row : rows) {
      put("", "  ", row.empty() ? "" : row.front());
      for (std::size_t i = 1; i < row.size() && i < names.size(); ++i) {
        const bool needs_name = names.size() > 2 && !names[i].empty() && !row[i].empty();
        put("    ", "    ", needs_name ? names[i] + ": " + row[i] : row[i]);
      }
    }
  }

  static constexpr std::size_t kGap = 2;

  Lines lines_;
  std::size_t columns_;
  std::size_t at_ = 0;
  std::string text_;
};

}  // namespace

std::string plain_words(std::string_view markdown) {
  std::string words;
  markdown = trimmed(markdown);
  while (!markdown.empty()) {
    const std::size_t code_end = markdown.starts_with('`') ? markdown.find('`', 1) : std::string_view::npos;
    const std::size_t picture = markdown.starts_with("![") ? 1 : 0;
    const std::size_t middle = markdown.find(']');
    const bool is_link = markdown.substr(picture).starts_with('[') && middle != std::string_view::npos &&
                         markdown.substr(middle + 1).starts_with('(');
    const std::size_t link_end = is_link ? markdown.find(')', middle) : std::string_view::npos;
    if (code_end != std::string_view::npos) {
      words += markdown.substr(1, code_end - 1);
      markdown.remove_prefix(code_end + 1);
    } else if (link_end != std::string_view::npos) {
      words += plain_words(markdown.substr(picture + 1, middle - picture - 1));
      markdown.remove_prefix(link_end + 1);
    } else if (markdown.starts_with("**")) {
      markdown.remove_prefix(2);
    } else {
      words += markdown.front();
      markdown.remove_prefix(1);
    }
  }
  return words;
}

std::string plain_text(std::string_view markdown, std::size_t columns) {
  return Page(markdown, columns).text();
}

}  // namespace contourd::ctl
