// Runs the print of a seed. A scenario that breaks a rule is reduced: everything not needed to break it is
// removed.
#pragma once

#include <string>

#include "tests/rig/scenario.hpp"
#include "tests/rig/verdict.hpp"

namespace contourd::rig {

[[nodiscard]] Verdict print(const Scenario& scenario);

// Returns a reduced scenario that still breaks the same rule: the first whose name begins with `rule_begin`.
// REQUIRES: the scenario breaks one.
[[nodiscard]] Scenario smaller(Scenario scenario, const std::string& rule_begin = {});

// Returns the scenario, the log of events and the broken rules.
[[nodiscard]] std::string report(const Scenario& scenario);

}  // namespace contourd::rig
