// The schema files of config/, built into the program: the truth for shape, ranges, units and defaults.
// Immutable once made; thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "daemon/json/json_document.hpp"
#include "daemon/json/schema_node.hpp"
#include "daemon/json/schema_reader.hpp"

namespace contourd {

class JsonSchema {
 public:
  // Draft 7, of which it knows: type, enum, minimum, maximum, minLength, maxLength, pattern, required,
  // properties, additionalProperties, items (one schema for all), minItems, maxItems, oneOf, definitions,
  // $ref (schema_reader.hpp), and what says nothing about what fits: title, description, default, examples,
  // $comment, $schema, $id. Throws nlohmann::json::exception when the text is not JSON, ConfigError for all
  // else. `name` is the file's in messages.
  explicit JsonSchema(std::string_view text, std::string name = "schema");
  // A schema that borrows parts of another, by its name: {"$ref": "NAME#/pointer"}.
  JsonSchema(std::string_view text, std::string name, const JsonSchema& other);
  JsonSchema(const JsonSchema&) = delete;
  JsonSchema& operator=(const JsonSchema&) = delete;

  // Adds every violation of the schema to the document, then gives the keys that are missing their defaults.
  void check(JsonDocument& document) const;

  [[nodiscard]] const SchemaNode& root() const { return *nodes_.front(); }
  // What a value at that place must fit. Its keys are members of objects. Throws std::out_of_range for one
  // that is not known.
  [[nodiscard]] const SchemaNode& at(const nlohmann::json::json_pointer& place) const;

 private:
  SchemaText text_;
  SchemaNodes nodes_;
};

// All of them are read when the first one is asked for.
[[nodiscard]] const JsonSchema& printer_schema();
[[nodiscard]] const JsonSchema& projector_schema();
[[nodiscard]] const JsonSchema& plate_schema();
[[nodiscard]] const JsonSchema& resin_schema();
[[nodiscard]] const JsonSchema& ticket_schema();

}  // namespace contourd
