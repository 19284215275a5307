// A parsed JSON schema, ready for checking documents. Immutable; thread-safe.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace contourd {

// A regular expression of a schema (ECMA 262), matched anywhere in a text, by Unicode characters. Immutable;
// thread-safe.
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
  struct Expression;
  std::shared_ptr<const Expression> expression_;
};

// A type name of the keyword "type".
struct JsonType {
  std::string_view name;
  std::string_view expected;  // as a noun phrase in messages
  bool (*fits)(const nlohmann::json&);
};

[[nodiscard]] std::span<const JsonType> json_types();

// One schema. Empty members impose no rule. The pointers refer to nodes of the same SchemaNodes and may form
// cycles.
struct SchemaNode {
  // The schema that "$ref" names. It replaces this one except for the description and the default given here.
  const SchemaNode* reference = nullptr;
  std::string description;
  std::optional<nlohmann::json> default_value;

  bool is_false = false;  // no value fits
  std::vector<const JsonType*> types;
  std::vector<nlohmann::json> enumeration;
  std::optional<nlohmann::json> minimum, maximum;  // numbers
  std::optional<std::size_t> min_length, max_length;
  std::optional<SchemaPattern> pattern;
  std::optional<std::size_t> min_items, max_items;
  const SchemaNode* items = nullptr;
  std::vector<std::string> required;
  std::map<std::string, const SchemaNode*> properties;
  const SchemaNode* additional_properties = nullptr;
  std::vector<const SchemaNode*> one_of;

  // Returns the node at the end of the chain of references, possibly this one.
  [[nodiscard]] const SchemaNode& followed() const;
  // Returns the first default along the chain of references, or null.
  [[nodiscard]] const nlohmann::json* default_here() const;
  // Returns the first description along the chain, without its full stop; "see the schema" if there is none.
  [[nodiscard]] std::string description_here() const;
};

using SchemaNodes = std::vector<std::unique_ptr<SchemaNode>>;

}  // namespace contourd
