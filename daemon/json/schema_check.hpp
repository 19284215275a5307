// Checks a document by a schema and says what is wrong. Pure functions, thread-safe.
#pragma once

#include "daemon/json/json_document.hpp"
#include "daemon/json/schema_node.hpp"

namespace contourd {

// Adds every violation to the document, the first 1,000 of them: more than that is a hostile document's, and
// nobody is told of them. Units come from the last key of a place that names one. Recursion is bounded by the
// document's depth.
void check_by_schema(const SchemaNode& schema, JsonDocument& document);

// Gives the keys that are missing their defaults, also in what is itself a default.
void fill_defaults(const SchemaNode& schema, nlohmann::json& value);

}  // namespace contourd
