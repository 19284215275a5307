// The schema of web.json; the build generates the definition.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view web_schema_text;

}  // namespace contourd
