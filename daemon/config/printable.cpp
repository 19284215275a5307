#include "daemon/config/printable.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace contourd {
namespace {

bool is_plain(char c) {
  return c >= 0x20 && c < 0x7F;
}

// Controls, and what turns or breaks the line without being seen: a name could look like another, or like
// more than one line.
bool is_unprintable(char32_t c) {
  struct Range {
    char32_t first, last;
  };
  constexpr std::array<Range, 11> ranges{{{0x00, 0x1F},
                                          {0x7F, 0x9F},
                                          {0x61C, 0x61C},
                                          {0x180E, 0x180E},
                                          {0x200B, 0x200B},
                                          {0x200E, 0x200F},
                                          {0x2028, 0x202E},
                                          {0x2060, 0x206F},
                                          {0xFEFF, 0xFEFF},
                                          {0xFFF9, 0xFFFB},
                                          {0xE0000, 0xE007F}}};
  return std::ranges::any_of(ranges, [c](const Range& range) { return c >= range.first && c <= range.last; });
}

// nlohmann-json replaces broken UTF-8 when it writes a string.
std::string valid_utf_8(std::string_view text) {
  const std::string quoted =
      nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

// The bytes of the character that begins with this one, in valid UTF-8.
std::size_t length_of(char first) {
  const auto byte = static_cast<unsigned char>(first);
  return byte < 0x80 ? 1 : byte < 0xE0 ? 2 : byte < 0xF0 ? 3 : 4;
}

char32_t character(std::string_view bytes) {
  const auto byte = [&](std::size_t at) {
    return static_cast<char32_t>(static_cast<unsigned char>(bytes[at]));
  };
  constexpr std::array<char32_t, 5> payload{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t value = byte(0) & payload[bytes.size()];
  for (std::size_t i = 1; i < bytes.size(); ++i)
    value = value << 6U | (byte(i) & 0x3FU);
  return value;
}

std::string cleaned(std::string_view text, bool keep_lines) {
  if (std::ranges::all_of(text, is_plain)) return std::string(text);
  const std::string valid = valid_utf_8(text);
  std::string clean;
  for (std::size_t at = 0; at < valid.size();) {
    const std::string_view bytes = std::string_view(valid).substr(at, length_of(valid[at]));
    at += bytes.size();
    const bool stays = !is_unprintable(character(bytes)) || (keep_lines && bytes == "\n");
    clean += stays ? bytes : "?";
  }
  return clean;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return std::string(text);
  const auto continues = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80;
  };
  while (bytes > 0 && continues(bytes))
    --bytes;
  return std::string(text.substr(0, bytes)) + "... (" + std::to_string(text.size() - bytes) + " bytes more)";
}

std::string printable(std::string_view text) {
  return cleaned(text, false);
}

std::string printable_lines(std::string_view text) {
  return cleaned(text, true);
}

}  // namespace contourd
