// Warns of a display that the schema allows but no projector has. Thread-safe (no shared state).
#pragma once

#include "daemon/json/json_document.hpp"

namespace contourd {

// Adds warnings about values in the printer's /display.
void warn_of_implausible_display(JsonDocument& printer);

}  // namespace contourd
