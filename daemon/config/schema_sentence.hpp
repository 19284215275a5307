// Sentences for what a schema has against one value. Pure functions, thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/config/json_document.hpp"

namespace contourd {

// Adds a violation for everything that `schema` has against `value` itself and the keys it has or lacks, not
// against what is in it. `pointer` is the value's place in the document; units come from the last key that
// names one.
void explain(const nlohmann::json& schema, const nlohmann::json& value, const std::string& pointer,
             JsonDocument& document);

}  // namespace contourd
