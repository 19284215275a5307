// Worlds with an emphasis: what goes wrong rarely where things go wrong at random, or only when two things
// come together. Pure functions.
#pragma once

#include "tests/rig/dice.hpp"
#include "tests/rig/scenario.hpp"

namespace contourd::rig {

// Changes the scenario to one of them; what the theme does not need stays as it was drawn.
void draw_theme(Dice& dice, Scenario& scenario);

}  // namespace contourd::rig
