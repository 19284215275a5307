// What is allowed of a real machine's switches, emergency stop and lid, and would leave a broken wire
// unnoticed.
#pragma once

#include "daemon/config/json_document.hpp"

namespace contourd {

// Adds warnings. REQUIRES: the schema was checked, so that defaults are there.
void warn_of_doubtful_contacts(JsonDocument& printer);

}  // namespace contourd
