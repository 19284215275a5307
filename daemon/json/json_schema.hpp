// The schema files of config/, built into the program. They alone define structure, ranges, units and
// defaults. Immutable; thread-safe.
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
  // Reads a schema in the subset of draft 7 with the keywords type, enum, minimum, maximum, minLength,
  // maxLength, pattern, required, properties, additionalProperties, items (one schema for all), minItems,
  // maxItems, oneOf, definitions, $ref (schema_reader.hpp), and the annotations title, description, default,
  // examples, $comment, $schema, $id. Throws nlohmann::json::exception if the text is not JSON, ConfigError
  // for any other error. `name` is the file's name in messages.
  explicit JsonSchema(std::string_view text, std::string name = "schema");
  // Reads a schema that may refer to parts of `other` by its name: {"$ref": "NAME#/pointer"}.
  JsonSchema(std::string_view text, std::string name, const JsonSchema& other);
  JsonSchema(const JsonSchema&) = delete;
  JsonSchema& operator=(const JsonSchema&) = delete;

  // Adds every violation of the schema to the document, then sets missing keys to their defaults.
  void check(JsonDocument& document) const;

  [[nodiscard]] const SchemaNode& root() const { return *nodes_.front(); }
  // Returns the schema for the value at that place, a pointer through members of objects. Throws
  // std::out_of_range for an unknown key.
  [[nodiscard]] const SchemaNode& at(const nlohmann::json::json_pointer& place) const;

 private:
  SchemaText text_;
  SchemaNodes nodes_;
};

// Return the built-in schemas; the first call of any of them reads all of them.
[[nodiscard]] const JsonSchema& printer_schema();
[[nodiscard]] const JsonSchema& projector_schema();
[[nodiscard]] const JsonSchema& plate_schema();
[[nodiscard]] const JsonSchema& resin_schema();
[[nodiscard]] const JsonSchema& ticket_schema();

}  // namespace contourd
