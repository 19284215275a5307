// Themes: scenarios for failures that are rare when failures are drawn at random, or that need two failures
// at once. Pure functions.
#pragma once

#include "tests/models/dice.hpp"
#include "tests/rig/scenario.hpp"

namespace contourd::rig {

using models::Dice;

// The number of states that a print enters for a layer, if nothing happens.
inline constexpr int kStatesOfALayer = 10;

// Changes the scenario to a random theme; settings that the theme does not need stay as they were drawn.
void draw_theme(Dice& dice, Scenario& scenario);

}  // namespace contourd::rig
