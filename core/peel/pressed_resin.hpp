// The resin that a part presses out of the gap above the film when the plate comes down, and the time until
// the plate has come to rest on it. Pure functions; thread-safe.
//
// Resin resists with a force F = viscosity * shape / gap^3 * speed (Stefan 1874; for a disc of radius R the
// shape is 3/2 pi R^4). It bends the axis, which gives way by F / stiffness, so that the plate lags behind
// and approaches its height exponentially: time constant = viscosity * shape / (gap^3 * stiffness).
#pragma once

#include <chrono>

#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// The resin and the axis that presses it out.
struct PressedResin {
  double viscosity_pa_s = 0;
  double stiffness_n_mm = 0;
  bool operator==(const PressedResin&) const = default;
};

// Returns the shape factor of a layer's lit area in the formula above, in mm^4. Solid areas count with their
// area A and the radius w of the largest circle within: between 3/2 A w^2, exact for a disc, and 4 A w^2,
// exact for a long strip. Dark areas that the light encloses count as cavities that are closed above: their
// resin, area C, must flow out below the wall of width 2 w along its rim of length P, which adds
// 12 * 2 w C^2 / P. Areas, holes and gaps narrower than about two pixels do not count, and openings of
// cavities above are not known: there the factor is too large. Parts 8 to 10 pixels wide get a factor that is
// off by up to 28 percent, wide ones by a few percent. Takes two milliseconds for a full HD mask, and a time
// in proportion to its pixels for others.
[[nodiscard]] double press_shape_mm4(const Mask& light, Micrometers pixel_pitch);

// Returns the shape factor of a full rectangle, such as the plate.
[[nodiscard]] double press_shape_mm4(Millimeters width, Millimeters height);

// Returns the time after which the lag of the plate has fallen to 5 percent: three time constants. REQUIRES:
// positive viscosity, stiffness and gap.
[[nodiscard]] std::chrono::duration<double> press_time(const PressedResin& resin, double shape_mm4,
                                                       Nanometers gap);

}  // namespace contourd
