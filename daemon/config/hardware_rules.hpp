// Rules for a real machine that no schema can say: what it cannot do without, and what would collide. Not
// thread-safe while the document is being checked.
#pragma once

#include "daemon/json/json_document.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

// Adds what is wrong to the printer's document. Keys that only a real machine needs are missed only where
// "hardware" says "real"; where they stand they are checked whatever it says, so that one file serves both.
// Behind printer_schema(): says nothing of what that found wrong.
void check_hardware_rules(JsonDocument& printer);
// The same for what depends on the projector's table.
void check_projector_table(JsonDocument& printer, const ProjectorTable& table);

}  // namespace contourd
