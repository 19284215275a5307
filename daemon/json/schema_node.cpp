#include "daemon/json/schema_node.hpp"

#include <array>
#include <cmath>

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

}  // namespace

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
