// The analysis page's parts; their definitions are made from analyze_page.* when the program is built.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view analyze_page_html;
extern const std::string_view analyze_page_style;
extern const std::string_view analyze_page_script;

}  // namespace contourd
