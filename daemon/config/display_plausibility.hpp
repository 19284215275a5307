// A display that a printer's file may have, and no projector has. Thread-safe (no shared state).
#pragma once

#include "daemon/config/json_document.hpp"

namespace contourd {

// Adds warnings at the printer's /display.
void warn_of_doubtful_display(JsonDocument& printer);

}  // namespace contourd
