// The files of the page, and the schema of web.json; the build generates the definitions.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view page_html_text;
extern const std::string_view page_css_text;
extern const std::string_view page_js_text;
extern const std::string_view page_icon_text;
extern const std::string_view web_schema_text;

}  // namespace contourd
