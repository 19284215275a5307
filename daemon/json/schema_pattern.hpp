// A regular expression of a schema (ECMA 262), matched anywhere in a text, by Unicode characters. Immutable;
// thread-safe.
#pragma once

#include <regex>
#include <string_view>

namespace contourd {

class SchemaPattern {
 public:
  // Throws std::invalid_argument with a readable message if `pattern` is not a regular expression or uses
  // what std::regex treats differently from ECMA 262: named classes, and escapes other than \d, \w, \D, \W,
  // \n, \r, \t and those of punctuation.
  explicit SchemaPattern(std::string_view pattern);

  // True if the pattern occurs in the text. Recursion is bounded by the text's length (limited in
  // json_syntax.hpp).
  [[nodiscard]] bool is_in(std::string_view text) const;

 private:
  std::wregex regex_;
};

}  // namespace contourd
