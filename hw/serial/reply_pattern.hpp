// What a projector's reply looks like: a line of text by a regular expression, or raw bytes by their hex
// values. Value type; const use is thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

enum class Checksum {
  None,
  SumAfterFirst,  // the last byte is the low byte of the sum of all before it but the first (ViewSonic)
};

// Of a message without its checksum byte. REQUIRES: a kind other than None.
[[nodiscard]] char checksum_of(std::string_view message, Checksum kind);

class ReplyPattern {
 public:
  // An ECMAScript regular expression that the whole line matches, without its line end and the control
  // characters and blanks around it. The first group, where there is one, is a decimal number: the reply's
  // value. Throws std::invalid_argument with what is wrong.
  [[nodiscard]] static ReplyPattern of_line(const std::string& expression);

  // "05 14 .. (..) sum": a byte's value, any byte, any byte of the reply's value (least significant first),
  // and at the end the checksum. Throws std::invalid_argument with what is wrong.
  [[nodiscard]] static ReplyPattern of_bytes(std::string_view hex, Checksum checksum);

  struct Match {
    std::optional<std::int64_t> value;
  };

  [[nodiscard]] bool is_of_bytes() const { return !bytes_.empty(); }
  // How many values a match gives: groups, or 1 where there are value bytes.
  [[nodiscard]] std::size_t values() const;
  // Whether bytes that mean nothing fit it, such as those of a line at the wrong speed.
  [[nodiscard]] bool fits_noise() const;

  // Nothing when the line is another, or its value no number that fits.
  [[nodiscard]] std::optional<Match> match_line(std::string_view line) const;
  // Nothing when the bytes received so far do not end in this reply.
  [[nodiscard]] std::optional<Match> match_end(std::string_view received) const;

 private:
  struct Byte {
    enum class Kind { Exact, Any, Value, Checksum };
    Kind kind;
    char exact;
  };
  [[nodiscard]] static Byte parse_byte(std::string_view token, Checksum checksum);

  std::optional<std::regex> line_;
  std::vector<Byte> bytes_;
  Checksum checksum_ = Checksum::None;
};

// "2A FA 0D": the bytes; the last may be "sum", the checksum, and one "{}", for which a number is put later
// and whose place is returned in `number_at`. A checksum that is written out is checked. Throws
// std::invalid_argument with what is wrong.
[[nodiscard]] std::string parse_hex_message(std::string_view hex, Checksum checksum,
                                            std::optional<std::size_t>& number_at);

}  // namespace contourd
