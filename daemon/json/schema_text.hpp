// The contents of the schema files; the build generates the definitions from config/*.schema.json.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view contourd_schema_text;
extern const std::string_view plate_schema_text;
extern const std::string_view projector_schema_text;
extern const std::string_view resin_schema_text;
extern const std::string_view ticket_schema_text;

}  // namespace contourd
