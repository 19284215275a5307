// Warns of switches, an emergency stop or a lid whose broken wire would go unnoticed.
#pragma once

#include "daemon/json/json_document.hpp"

namespace contourd {

// Adds the warnings. Ignores contacts without defaults; run printer_schema() first, which sets them.
void warn_of_implausible_contacts(JsonDocument& printer);

}  // namespace contourd
