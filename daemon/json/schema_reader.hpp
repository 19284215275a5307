// Reads a JSON schema (draft 7) into nodes and refuses what it does not know. Pure functions, thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/json/schema_node.hpp"

namespace contourd {

struct SchemaText {
  std::string name;  // the file's
  nlohmann::json value;
};

// The nodes, the outermost schema first. `{"$ref": "#/pointer"}` refers to a part of the text that it stands
// in,
// `{"$ref": "NAME#/pointer"}` to one of `other`, which may be null. What stands beside "$ref" is ignored, as
// the draft says, but for "description" and "default". Throws ConfigError, which names the place, for a
// keyword that is not known or has a value that it cannot have, for a reference to nothing, and for a circle
// of references that says nothing about what is in a value.
[[nodiscard]] SchemaNodes read_schema(const SchemaText& text, const SchemaText* other);

}  // namespace contourd
