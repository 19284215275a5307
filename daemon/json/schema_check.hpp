// Validates a document against a schema. Pure functions, thread-safe.
#pragma once

#include "daemon/json/json_document.hpp"
#include "daemon/json/schema_node.hpp"

namespace contourd {

// Adds the violations to the document, at most 1,000; only a hostile document has more. A message takes its
// unit from the last key in the pointer that names one. Recursion is bounded by the document's depth.
void check_by_schema(const SchemaNode& schema, JsonDocument& document);

// Sets missing keys to their defaults, also within values that are defaults themselves.
void fill_defaults(const SchemaNode& schema, nlohmann::json& value);

}  // namespace contourd
