// The project's pages for users (docs/*.md) as Markdown, each named after its file.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view configuration_page, connections_page, control_api_page, first_print_page,
    glossary_page, maintenance_page, printer_setup_page, printing_page, safety_page, trouble_page;

}  // namespace contourd
