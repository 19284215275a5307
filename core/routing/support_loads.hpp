// How thick a branch is: by the load that comes down through it, and by its length between where it meets
// others. Thread-safe (no shared state). Deterministic.
//
// Against buckling. Euler's load of a column goes with d^4 / L^2. The measure is PrusaSlicer's: a pillar of
// 1 mm may stand alone up to 15 mm high under one tip, that is, with what a tip holds. So
//   d = pillar diameter * sqrt(L / 15 mm) * (load / what a tip holds)^(1/4).
// Against tearing. No section is pulled harder than the tips are:
//   d = tip diameter * sqrt(load / what a tip holds).
// The thicker counts, and the pillar's diameter at least. There are no braces: a pillar of 30 mm needs twice
// the area of one of 15 mm instead, which is less than a second pillar and the struts to it.
#pragma once

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Of a branch of that length between where it meets others, in millimetres.
[[nodiscard]] double branch_radius(double load_mm2, double length_mm, const SupportSettings& settings);

// Of a foot on a model, where it meets the model: pressed no harder than a tip is pulled.
[[nodiscard]] double landing_radius(double load_mm2, const SupportSettings& settings);

// Makes the tree's branches as thick as they have to be, where there is room; those that have too little
// fill it. REQUIRES: every node leads down to a lower one or to none.
void thicken_branches(SupportTree& tree, const ClearanceField& field, const SupportSettings& settings);

}  // namespace contourd
