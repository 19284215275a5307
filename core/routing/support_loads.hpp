// The thickness of branches, which depends on the load that a branch carries and on its length between
// junctions. Thread-safe (no shared state). Deterministic.
//
// Against buckling: Euler's load of a column goes with d^4 / L^2. The scale is PrusaSlicer's: a pillar of 1
// mm may stand alone up to 15 mm high under one tip, that is, with the load that one tip holds. So
//   d = pillar diameter * sqrt(L / 15 mm) * (load / tip load)^(1/4).
// Against tearing: no section is pulled harder than the tips are:
//   d = tip diameter * sqrt(load / tip load).
// The greater diameter counts, and at least the pillar's diameter. There are no braces: a pillar of 30 mm
// needs twice the area of one of 15 mm instead, which is less than a second pillar and the struts to it.
#pragma once

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns the radius of a branch of that length between junctions, in millimetres.
[[nodiscard]] double branch_radius(double load_mm2, double length_mm, const SupportSettings& settings);

// Returns the radius of a foot on a model where it meets the model: pressed no harder than a tip is pulled.
[[nodiscard]] double landing_radius(double load_mm2, const SupportSettings& settings);

// Makes the tree's branches as thick as they have to be, or as thick as there is room. REQUIRES: every node
// leads down to a lower one or to none.
void thicken_branches(SupportTree& tree, const ClearanceField& field, const SupportSettings& settings);

}  // namespace contourd
