#include "daemon/json/schema_node.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <regex>
#include <stdexcept>

#include "daemon/json/config_error.hpp"
#include "daemon/system/utf_8.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// True also for whole numbers too large for an integer: they are out of range, not of the wrong type.
bool is_whole(const json& value) {
  return value.is_number_integer() || (value.is_number_float() && std::trunc(value.get<double>()) == value);
}

constexpr std::array<JsonType, 7> kTypes{{
    {"object", "an object", [](const json& value) { return value.is_object(); }},
    {"array", "a list", [](const json& value) { return value.is_array(); }},
    {"string", "a text", [](const json& value) { return value.is_string(); }},
    {"boolean", "true or false", [](const json& value) { return value.is_boolean(); }},
    {"number", "a number", [](const json& value) { return value.is_number(); }},
    {"integer", "a whole number", is_whole},
    {"null", "null", [](const json& value) { return value.is_null(); }},
}};

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

struct SchemaPattern::Expression {
  std::wregex regex;
};

SchemaPattern::SchemaPattern(std::string_view pattern)
    : expression_(std::make_shared<Expression>(Expression{compiled(pattern)})) {}

bool SchemaPattern::is_in(std::string_view text) const {
  return std::regex_search(wide(text), expression_->regex);
}

std::span<const JsonType> json_types() {
  return kTypes;
}

const SchemaNode& SchemaNode::followed() const {
  const SchemaNode* node = this;
  while (node->reference != nullptr)
    node = node->reference;
  return *node;
}

const json* SchemaNode::default_here() const {
  const SchemaNode* node = this;
  while (!node->default_value && node->reference != nullptr)
    node = node->reference;
  return node->default_value ? &*node->default_value : nullptr;
}

std::string SchemaNode::description_here() const {
  const SchemaNode* node = this;
  while (node->description.empty() && node->reference != nullptr)
    node = node->reference;
  std::string text = node->description.empty() ? "see the schema" : node->description;
  while (text.ends_with('.'))
    text.pop_back();
  return text;
}

}  // namespace contourd
