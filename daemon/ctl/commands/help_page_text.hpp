// The project's pages for owners (docs/), as they are written, each under its file's name.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view configuration_page, connections_page, control_api_page, first_print_page,
    glossary_page, maintenance_page, printer_setup_page, printing_page, safety_page, trouble_page;

}  // namespace contourd
