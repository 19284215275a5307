// Parses a JSON schema (draft 7) into nodes and rejects unsupported keywords. Pure functions, thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/json/schema_node.hpp"

namespace contourd {

struct SchemaText {
  std::string name;  // name of the file
  nlohmann::json value;
};

// Returns the nodes, with the outermost schema first. The reference "#/pointer" is to a part of the same
// text, "NAME#/pointer" to a part of `other`, which may be null. Keywords beside "$ref" are ignored, as the
// draft requires, except "description" and "default". Throws ConfigError with the place of an unsupported
// keyword, an invalid value of a keyword, a reference to a missing part, or a cycle of references that never
// descends into a value.
[[nodiscard]] SchemaNodes read_schema(const SchemaText& text, const SchemaText* other);

}  // namespace contourd
