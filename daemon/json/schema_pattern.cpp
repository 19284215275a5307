#include "daemon/json/schema_pattern.hpp"

#include <limits>
#include <stdexcept>
#include <string>

#include "daemon/json/config_error.hpp"
#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

// Returns the text with one wchar_t per character.
std::wstring wide(std::string_view text) {
  static_assert(std::numeric_limits<wchar_t>::digits >= 21);
  const std::u32string points = code_points(text);
  return {points.begin(), points.end()};
}

void check_escapes(std::string_view pattern) {
  constexpr std::string_view kKnown = "dDwWnrt^$\\.*+?()[]{}|/-";
  for (std::size_t at = pattern.find('\\'); at != std::string_view::npos; at = pattern.find('\\', at + 2)) {
    const std::string_view escape = pattern.substr(at, 2);
    if (escape.size() < 2 || kKnown.find(escape[1]) == std::string_view::npos)
      throw std::invalid_argument("the escape " + in_quotes(escape) + " is not supported");
  }
}

void check_named_classes(std::string_view pattern) {
  for (const std::string_view start : {"[:", "[.", "[="}) {
    if (pattern.find(start) != std::string_view::npos)
      throw std::invalid_argument(in_quotes(start) + " in a pattern is not supported");
  }
}

std::wregex compiled(std::string_view pattern) {
  check_escapes(pattern);
  check_named_classes(pattern);
  try {
    return std::wregex(wide(pattern));
  } catch (const std::regex_error&) {
    throw std::invalid_argument(in_quotes(pattern) + " is not a regular expression");
  }
}

}  // namespace

SchemaPattern::SchemaPattern(std::string_view pattern) : regex_(compiled(pattern)) {}

bool SchemaPattern::is_in(std::string_view text) const {
  return std::regex_search(wide(text), regex_);
}

}  // namespace contourd
