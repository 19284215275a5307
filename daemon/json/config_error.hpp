// What is wrong or implausible in an owner's file: every violation, with its file and its place. Value types;
// thread-safe as any value is.
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

// The search ends after so many: a file of a megabyte may have half a million.
inline constexpr std::size_t kMaxViolations = 1000;

// what() is one line a violation: `FILE: /pointer: message`, fit for a person (printable.hpp); of many, the
// first 30 and how many there are more, or at least.
class ConfigError : public std::runtime_error {
 public:
  // REQUIRES: at least one violation.
  explicit ConfigError(std::vector<Violation> violations);

  [[nodiscard]] const std::vector<Violation>& violations() const noexcept { return violations_; }
  // what() with semicolons for its line breaks.
  [[nodiscard]] std::string in_one_line() const;

 private:
  std::vector<Violation> violations_;
};

// `FILE: warning: /pointer: message`, in the same way: of what is no error.
[[nodiscard]] std::string warning_line(const Violation& warning);

// The text in double quotes, cut at 60 bytes, fit for a message (printable.hpp).
[[nodiscard]] std::string in_quotes(std::string_view text);

// The shortest decimal form of a number in a file.
[[nodiscard]] std::string decimal(double number);

// The pointer to the member or element `token` of what `pointer` points to.
[[nodiscard]] std::string child_pointer(std::string_view pointer, std::string_view token);

}  // namespace contourd
