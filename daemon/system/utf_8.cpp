#include "daemon/system/utf_8.hpp"

#include <algorithm>
#include <array>

#include "core/contract/expects.hpp"

namespace contourd {
bool continues_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

std::size_t utf_8_length(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (text.size() < length) return 0;
  const unsigned low = lead == 0xE0 ? 0xA0U : lead == 0xF0 ? 0x90U : 0x80U;
  const unsigned high = lead == 0xED ? 0x9FU : lead == 0xF4 ? 0x8FU : 0xBFU;
  if (byte(1) < low || byte(1) > high) return 0;
  const std::string_view rest = text.substr(2, length - 2);
  return std::ranges::all_of(rest, continues_character) ? length : 0;
}

std::optional<std::size_t> first_invalid_utf_8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf_8_length(text.substr(at));
    if (length == 0) return at;
    at += length;
  }
  return std::nullopt;
}

std::string_view cut_utf_8(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  // A character has at most three continuation bytes; a longer run is not a character.
  for (int i = 0; i < 3 && bytes > 0 && continues_character(text[bytes]); ++i)
    --bytes;
  return text.substr(0, bytes);
}

char32_t code_point(std::string_view character) {
  expects(!character.empty() && utf_8_length(character) == character.size(), "it is one character");
  constexpr std::array<unsigned, 5> kPayload{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t value = static_cast<unsigned char>(character[0]) & kPayload[character.size()];
  for (const char byte : character.substr(1))
    value = value << 6U | (static_cast<unsigned char>(byte) & 0x3FU);
  return value;
}

std::u32string code_points(std::string_view text) {
  std::u32string points;
  while (!text.empty()) {
    const std::size_t length = utf_8_length(text);
    points += length == 0 ? U'\uFFFD' : code_point(text.substr(0, length));
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return points;
}

}  // namespace contourd
