// Prints by their seeds. What one shows is made smaller: everything is taken away that it does not need to
// show it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/rig/scenario.hpp"
#include "tests/rig/verdict.hpp"

namespace contourd::rig {

[[nodiscard]] Verdict print(const Scenario& scenario);

// Breaks the same rule still: the first that begins so. REQUIRES: the scenario breaks one.
[[nodiscard]] Scenario smaller(Scenario scenario, const std::string& rule_begin = {});

// The scenario, the rules broken, and what happened.
[[nodiscard]] std::string report(const Scenario& scenario);

}  // namespace contourd::rig
