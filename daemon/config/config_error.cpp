#include "daemon/config/config_error.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

namespace contourd {
namespace {

constexpr std::size_t longest_quote = 60;
// How much of what is wrong is told: more than anybody mends at once.
constexpr std::size_t most_lines = 30;
constexpr std::size_t longest_pointer = 200;

// Without control characters: a file name or a key with a line break in it must not look like two violations.
std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      result += c;
    } else {
      result += "\\x";
      result += digits[byte >> 4U];
      result += digits[byte & 15U];
    }
  }
  return result;
}

// Cut at `bytes`, never within a character, with dots for the rest.
std::string shortened(std::string_view text, std::size_t bytes) {
  std::string shown(text.substr(0, bytes));
  if (shown.size() == text.size()) return shown;
  const auto continues = [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; };
  for (std::size_t end = shown.size(); end > 0 && continues(text[end]); --end)
    shown.resize(end - 1);
  return shown + "...";
}

// "FILE: severity/pointer: message"
std::string line(const Violation& violation, const char* severity) {
  std::string text = printable(violation.file) + ": " + severity;
  if (!violation.pointer.empty()) text += printable(shortened(violation.pointer, longest_pointer)) + ": ";
  return text + violation.message;
}

std::string lines(const std::vector<Violation>& violations) {
  std::string text;
  const std::size_t shown = std::min(violations.size(), most_lines);
  for (std::size_t i = 0; i < shown; ++i)
    text += (text.empty() ? "" : "\n") + line(violations[i], "");
  if (shown < violations.size()) text += "\nand " + std::to_string(violations.size() - shown) + " more";
  return text;
}

}  // namespace

ConfigError::ConfigError(std::vector<Violation> violations)
    : std::runtime_error(lines(violations)), violations_(std::move(violations)) {}

std::string warning_line(const Violation& warning) {
  return line(warning, "warning: ");
}

std::string in_quotes(std::string_view text) {
  constexpr auto replace = nlohmann::json::error_handler_t::replace;
  return printable(nlohmann::json(shortened(text, longest_quote)).dump(-1, ' ', false, replace));
}

std::string child_pointer(std::string_view pointer, std::string_view token) {
  std::string result(pointer);
  result += '/';
  for (const char c : token) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace contourd
