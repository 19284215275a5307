// The form of a projector's reply: a line of text, given as a regular expression, or raw bytes, given as hex
// values. Value type; const use is thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

enum class Checksum {
  None,
  SumAfterFirst,  // the last byte is the low byte of the sum of all before it but the first (ViewSonic)
};

// Returns the checksum of a message that has no checksum byte yet. REQUIRES: a kind other than None.
[[nodiscard]] char checksum_of(std::string_view message, Checksum kind);

class ReplyPattern {
 public:
  // Makes a pattern of an ECMAScript regular expression that the whole line must match, without its line end
  // and the control characters and blanks around it. The first group, if there is one, is a decimal number:
  // the reply's value. Throws std::invalid_argument, which says what is wrong.
  [[nodiscard]] static ReplyPattern of_line(const std::string& expression);

  // Makes a pattern of bytes such as "05 14 .. (..) sum": a byte's value, any byte, any byte of the reply's
  // value (least significant first), and at the end the checksum. Throws std::invalid_argument, which says
  // what is wrong.
  [[nodiscard]] static ReplyPattern of_bytes(std::string_view hex, Checksum checksum);

  struct Match {
    std::optional<std::int64_t> value;
  };

  [[nodiscard]] bool is_of_bytes() const { return !bytes_.empty(); }
  // Returns the number of values that a match gives: the number of groups, or 1 if there are value bytes.
  [[nodiscard]] std::size_t values() const;
  // True if meaningless bytes fit the pattern, such as those of a line at the wrong speed.
  [[nodiscard]] bool fits_noise() const;

  // Returns nullopt if the line does not match, or its value is not a number that fits.
  [[nodiscard]] std::optional<Match> match_line(std::string_view line) const;
  // Returns nullopt if the bytes received so far do not end in this reply.
  [[nodiscard]] std::optional<Match> match_end(std::string_view received) const;

 private:
  struct Byte {
    enum class Kind { Exact, Any, Value, Checksum };
    Kind kind;
    char exact;
  };
  [[nodiscard]] static Byte parse_byte(std::string_view token, Checksum checksum);

  struct Line;
  std::shared_ptr<const Line> line_;  // null for bytes
  std::vector<Byte> bytes_;
  Checksum checksum_ = Checksum::None;
};

// Returns the bytes of a message such as "2A FA 0D". The last byte may be "sum", for the checksum, and one
// byte may be "{}", for a number that is put in later; its place is returned in `number_at`. A checksum that
// is written out is checked. Throws std::invalid_argument, which says what is wrong.
[[nodiscard]] std::string parse_hex_message(std::string_view hex, Checksum checksum,
                                            std::optional<std::size_t>& number_at);

// Returns received bytes, cut at 32 bytes, in readable form for messages: printable ASCII as it is, all else
// as \r, \n or \xHH, in quotes.
[[nodiscard]] std::string readable_bytes(std::string_view bytes);

}  // namespace contourd
