#include "hw/serial/readable_bytes.hpp"

#include <cstddef>

namespace contourd {
namespace {

std::string readable_byte(char c) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const auto byte = static_cast<unsigned char>(c);
  if (c == '\r') return "\\r";
  if (c == '\n') return "\\n";
  if (c == '"' || c == '\\') return {'\\', c};
  if (byte >= 0x20 && byte < 0x7f) return {c};
  return {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
}

}  // namespace

std::string readable_bytes(std::string_view bytes) {
  constexpr std::size_t kMaxBytes = 32;
  std::string text = "\"";
  for (const char c : bytes.substr(0, kMaxBytes))
    text += readable_byte(c);
  return text + (bytes.size() > kMaxBytes ? "...\"" : "\"");
}

}  // namespace contourd
