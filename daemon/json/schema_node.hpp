// A JSON schema in the form that documents are checked with: read once, every keyword known.
// Immutable once made; thread-safe.
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

#include "daemon/json/schema_pattern.hpp"

namespace contourd {

// A name that `type` may give.
struct JsonType {
  std::string_view name;
  std::string_view expected;  // in a sentence
  bool (*fits)(const nlohmann::json&);
};

[[nodiscard]] std::span<const JsonType> json_types();

// One schema. What is empty asks for nothing. Points to other nodes of the same SchemaNodes, also in a
// circle.
struct SchemaNode {
  // Stands for this one but for the description and the default that are given here.
  const SchemaNode* reference = nullptr;
  std::string description;
  std::optional<nlohmann::json> default_value;

  bool is_false = false;  // nothing fits
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

  // This one, or what it refers to at last.
  [[nodiscard]] const SchemaNode& followed() const;
  // Its own, or that of what it refers to.
  [[nodiscard]] const nlohmann::json* default_here() const;
  // In the same way, without its full stop; "see the schema" where there is none.
  [[nodiscard]] std::string description_here() const;
};

using SchemaNodes = std::vector<std::unique_ptr<SchemaNode>>;

}  // namespace contourd
