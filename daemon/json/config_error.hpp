// Errors and warnings about a user's file: every violation, with its file and place. Value types; thread-safe
// as any value is.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

struct Violation {
  std::string file;
  std::string pointer;  // JSON pointer (RFC 6901); empty for the whole file
  std::string message;  // one clause, without the place

  bool operator==(const Violation&) const = default;
};

// The check stops after this many violations: a file of a megabyte may have half a million.
inline constexpr std::size_t kMaxViolations = 1000;

// The violations of one or more files. what() has one line per violation, `FILE: /pointer: message`, safe to
// show (printable()): the first 20 violations, then the number of further ones.
class ConfigError : public std::runtime_error {
 public:
  // REQUIRES: at least one violation.
  explicit ConfigError(std::vector<Violation> violations);

  [[nodiscard]] const std::vector<Violation>& violations() const noexcept { return violations_; }
  // Returns what() with semicolons instead of line breaks.
  [[nodiscard]] std::string in_one_line() const;

 private:
  std::vector<Violation> violations_;
};

// Returns `FILE: warning: /pointer: message`, safe to show.
[[nodiscard]] std::string warning_line(const Violation& warning);

// Returns the text in double quotes, cut at 60 bytes, safe to show (printable()).
[[nodiscard]] std::string in_quotes(std::string_view text);

// Returns the shortest decimal form of a number.
[[nodiscard]] std::string decimal(double number);

// Returns the JSON pointer to the member or element `token` of the value at `pointer`.
[[nodiscard]] std::string child_pointer(std::string_view pointer, std::string_view token);

}  // namespace contourd
