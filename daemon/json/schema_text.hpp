// The schema files' bytes; the definitions are generated from config/*.schema.json when the program is built.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view contourd_schema_text;
extern const std::string_view plate_schema_text;
extern const std::string_view projector_schema_text;
extern const std::string_view resin_schema_text;
extern const std::string_view ticket_schema_text;

}  // namespace contourd
