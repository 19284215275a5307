// Parts of the analysis page; the build generates their definitions from analyze_page.*.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view analyze_page_html;
extern const std::string_view analyze_page_style;
extern const std::string_view analyze_page_script;

}  // namespace contourd
