#include "hw/serial/reply_pattern.hpp"

#include <algorithm>
#include <charconv>
#include <regex>
#include <stdexcept>
#include <system_error>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMaxValueBytes = 4;

std::vector<std::string_view> tokens_of(std::string_view text) {
  std::vector<std::string_view> tokens;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.empty()) return tokens;
    const std::size_t end = std::min(text.find(' '), text.size());
    tokens.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

std::optional<char> hex_byte(std::string_view token) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value, 16);
  if (token.size() != 2 || error != std::errc() || end != token.data() + token.size()) return std::nullopt;
  return static_cast<char>(value);
}

std::string hex_of(char c) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const auto byte = static_cast<unsigned char>(c);
  return {kDigits[byte >> 4U], kDigits[byte & 15U]};
}

std::string readable_byte(char c) {
  if (c == '\r') return "\\r";
  if (c == '\n') return "\\n";
  if (c == '"' || c == '\\') return {'\\', c};
  return c >= 0x20 && c < 0x7f ? std::string{c} : "\\x" + hex_of(c);
}

void require_checksum(Checksum checksum) {
  if (checksum == Checksum::None)
    throw std::invalid_argument("\"sum\" stands for a checksum, but the table's checksum is \"none\"");
}

[[noreturn]] void reject(std::string_view token, const char* allowed) {
  throw std::invalid_argument("\"" + std::string(token) + "\" is not a byte; " + allowed);
}

std::optional<std::int64_t> number_in(std::string_view digits) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

}  // namespace

struct ReplyPattern::Line {
  std::regex regex;
};

char checksum_of(std::string_view message, Checksum kind) {
  expects(kind != Checksum::None, "there is a checksum");
  unsigned sum = 0;
  for (const char c : message.substr(std::min<std::size_t>(1, message.size())))
    sum += static_cast<unsigned char>(c);
  return static_cast<char>(sum & 0xffU);
}

ReplyPattern ReplyPattern::of_line(const std::string& expression) {
  ReplyPattern pattern;
  try {
    pattern.line_ = std::make_shared<Line>(Line{std::regex(expression, std::regex::ECMAScript)});
  } catch (const std::regex_error& error) {
    throw std::invalid_argument(error.what());
  }
  return pattern;
}

ReplyPattern::Byte ReplyPattern::parse_byte(std::string_view token, Checksum checksum) {
  if (token == "..") return {Byte::Kind::Any, 0};
  if (token == "(..)") return {Byte::Kind::Value, 0};
  if (token == "sum") {
    require_checksum(checksum);
    return {Byte::Kind::Checksum, 0};
  }
  const std::optional<char> exact = hex_byte(token);
  if (!exact)
    reject(token, "write two hex digits, \"..\" for any byte, \"(..)\" for the value's, or \"sum\"");
  return {Byte::Kind::Exact, *exact};
}

ReplyPattern ReplyPattern::of_bytes(std::string_view hex, Checksum checksum) {
  ReplyPattern pattern;
  pattern.checksum_ = checksum;
  std::size_t value_bytes = 0;
  for (const std::string_view token : tokens_of(hex)) {
    if (!pattern.bytes_.empty() && pattern.bytes_.back().kind == Byte::Kind::Checksum)
      throw std::invalid_argument("\"sum\" must come last");
    pattern.bytes_.push_back(parse_byte(token, checksum));
    if (pattern.bytes_.back().kind == Byte::Kind::Value) ++value_bytes;
  }
  if (pattern.bytes_.empty()) throw std::invalid_argument("the text has no bytes");
  if (value_bytes > kMaxValueBytes) throw std::invalid_argument("a value has at most 4 bytes");
  return pattern;
}

std::size_t ReplyPattern::values() const {
  if (line_) return line_->regex.mark_count();
  for (const Byte& byte : bytes_) {
    if (byte.kind == Byte::Kind::Value) return 1;
  }
  return 0;
}

bool ReplyPattern::fits_noise() const {
  if (!line_) {
    return std::none_of(bytes_.begin(), bytes_.end(),
                        [](const Byte& byte) { return byte.kind == Byte::Kind::Exact; });
  }
  constexpr std::string_view kBytes = "\x8f\xe0\x93\xf8\xc7\x9e\xfc\xe3\x87\xf1\x9c\xce\xe7\xf3\x8c\xb9";
  constexpr std::string_view kWords = "qZ7jXk3vWz9QbJ4y";
  for (std::size_t size = 1; size <= kWords.size(); ++size) {
    // One letter may well be a reply.
    if (match_line(kBytes.substr(0, size)) || (size > 1 && match_line(kWords.substr(0, size)))) return true;
  }
  return false;
}

std::optional<ReplyPattern::Match> ReplyPattern::match_line(std::string_view line) const {
  if (!line_) return std::nullopt;
  std::match_results<std::string_view::const_iterator> groups;
  if (!std::regex_match(line.begin(), line.end(), groups, line_->regex)) return std::nullopt;
  if (groups.size() < 2) return Match{};
  const std::optional<std::int64_t> value = number_in(groups[1].str());
  if (!value) return std::nullopt;
  return Match{value};
}

std::optional<ReplyPattern::Match> ReplyPattern::match_end(std::string_view received) const {
  if (bytes_.empty() || received.size() < bytes_.size()) return std::nullopt;
  const std::string_view reply = received.substr(received.size() - bytes_.size());
  Match match;
  unsigned shift = 0;
  for (std::size_t i = 0; i < bytes_.size(); ++i) {
    const Byte& expected = bytes_[i];
    if (expected.kind == Byte::Kind::Exact && reply[i] != expected.exact) return std::nullopt;
    if (expected.kind == Byte::Kind::Checksum && reply[i] != checksum_of(reply.substr(0, i), checksum_))
      return std::nullopt;
    if (expected.kind != Byte::Kind::Value) continue;
    match.value = match.value.value_or(0) |
                  static_cast<std::int64_t>(std::uint64_t{static_cast<unsigned char>(reply[i])} << shift);
    shift += 8;
  }
  return match;
}

std::string parse_hex_message(std::string_view hex, Checksum checksum,
                              std::optional<std::size_t>& number_at) {
  std::string message;
  bool has_sum = false;
  for (const std::string_view token : tokens_of(hex)) {
    if (has_sum) throw std::invalid_argument("\"sum\" must come last");
    if (token == "{}") {
      if (number_at) throw std::invalid_argument("there is more than one {}");
      number_at = message.size();
      message += '\0';
    } else if (token == "sum") {
      require_checksum(checksum);
      has_sum = true;
      message += '\0';
    } else if (const std::optional<char> byte = hex_byte(token)) {
      message += *byte;
    } else {
      reject(token, "write two hex digits, or \"sum\" for the checksum");
    }
  }
  if (message.empty()) throw std::invalid_argument("the text has no bytes");
  if (checksum == Checksum::None) return message;
  const char sum = checksum_of(std::string_view(message).substr(0, message.size() - 1), checksum);
  if (!has_sum && number_at) throw std::invalid_argument("with a {} in it, its checksum must be \"sum\"");
  if (!has_sum && message.back() != sum) {
    throw std::invalid_argument("its last byte is " + hex_of(message.back()) + ", but the checksum is " +
                                hex_of(sum));
  }
  message.back() = sum;
  return message;
}

std::string readable_bytes(std::string_view bytes) {
  constexpr std::size_t kMaxBytes = 32;
  std::string text = "\"";
  for (const char c : bytes.substr(0, kMaxBytes))
    text += readable_byte(c);
  return text + (bytes.size() > kMaxBytes ? "...\"" : "\"");
}

}  // namespace contourd
