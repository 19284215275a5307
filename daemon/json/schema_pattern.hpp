// A regular expression of a schema: ECMA 262, searched for anywhere in a text, by characters.
// Immutable once made; thread-safe.
#pragma once

#include <regex>
#include <string_view>

namespace contourd {

class SchemaPattern {
 public:
  // Throws std::invalid_argument, with a sentence, for what is none, and for what std::regex takes otherwise
  // than ECMA 262: other escapes than \d, \w, \D, \W, \n, \r, \t and those of punctuation, and named classes.
  explicit SchemaPattern(std::string_view pattern);

  // Recursion is bounded by the text's length, which json_syntax.hpp bounds.
  [[nodiscard]] bool is_in(std::string_view text) const;

 private:
  std::wregex regex_;
};

}  // namespace contourd
