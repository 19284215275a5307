// Warns of switches, an emergency stop or a lid whose broken wire would go unnoticed.
#pragma once

#include "daemon/json/json_document.hpp"

namespace contourd {

// Adds warnings. Says nothing of contacts without their defaults: they come from printer_schema().
void warn_of_implausible_contacts(JsonDocument& printer);

}  // namespace contourd
