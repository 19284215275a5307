// Rules for a real machine that a schema cannot express: required keys and conflicts between keys. Not
// thread-safe while the document is being checked.
#pragma once

#include "daemon/json/json_document.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

// Adds violations to the printer's document. Keys that only a real machine needs are required only if
// "hardware" is "real", but are checked whenever they are present, so that one file serves both. Call it
// after printer_schema(); it ignores values that the schema has already rejected.
void check_hardware_rules(JsonDocument& printer);
// Adds the violations that depend on the projector's table.
void check_projector_table(JsonDocument& printer, const ProjectorTable& table);

}  // namespace contourd
