// The schema files of config/, built into the program: the truth for shape, ranges, units and defaults.
// Immutable once made; thread-safe.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/config/json_document.hpp"

namespace contourd {

class JsonSchema {
 public:
  // Draft 7, of which the sentences know: type, enum, minimum, maximum, minLength, maxLength, pattern,
  // required, properties, additionalProperties: false, items (one schema for all), minItems, maxItems, and
  // oneOf as a choice between sets of required keys, and {"$ref": "#/pointer"} to a part of the same text.
  // Throws nlohmann::json::exception or std::runtime_error when the text is no schema.
  explicit JsonSchema(std::string_view text);
  // A schema that borrows parts of another: every {"$ref": "FILE#/pointer"} is replaced by what is there in
  // `other`, which is FILE.
  JsonSchema(std::string_view text, std::string_view file, const JsonSchema& other);
  ~JsonSchema();
  JsonSchema(const JsonSchema&) = delete;
  JsonSchema& operator=(const JsonSchema&) = delete;

  // Adds every violation of the schema to the document, then gives the keys that are missing their defaults.
  void check(JsonDocument& document) const;

  // References resolved.
  [[nodiscard]] const nlohmann::json& value() const;

 private:
  struct Compiled;
  std::unique_ptr<Compiled> compiled_;
};

[[nodiscard]] const JsonSchema& printer_schema();
[[nodiscard]] const JsonSchema& projector_schema();
[[nodiscard]] const JsonSchema& plate_schema();
[[nodiscard]] const JsonSchema& resin_schema();
[[nodiscard]] const JsonSchema& ticket_schema();

}  // namespace contourd
