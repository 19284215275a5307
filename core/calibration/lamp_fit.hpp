// The light of a lamp over a display, from readings at several places, and the uniformity mask that evens it
// out. Values and pure functions; thread-safe.
//
// A surface that is a polynomial of the place, of the second to the fourth degree, is fitted to the readings
// by least squares. A lamp's light falls off smoothly from a brightest place, so that such a surface averages
// the errors of the meter, which a surface through all readings would put into the mask. The degree is the
// one whose surface predicts each reading best from the others (Allen 1974, PRESS).
#pragma once

#include <cstddef>
#include <span>

#include "core/calibration/linear_fit.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// A place on a display as pictures are sent to it: -1 at the left or upper edge, 1 at the right or lower one.
struct LampPlace {
  double x = 0, y = 0;
};

// The light at a place, in any unit that grows in proportion to it.
struct LampReading {
  LampPlace place;
  double light = 0;
};

inline constexpr std::size_t kMostLampReadings = 1000;

// A polynomial of the place; its terms are 1, x, y, x², xy, y² and so on up to the degree.
struct LampSurface {
  int degree = 0;
  LinearFit fit{};

  // Returns the light at a place, and its standard uncertainty.
  [[nodiscard]] Estimate at(LampPlace place) const;
};

struct LampFit {
  LampSurface surface;
  LampReading darkest, brightest;  // places of the surface
  double spread_percent = 0;       // by which the brightest place is brighter than the darkest
  double worst_percent = 0;  // standard uncertainty of the surface where it is largest, of the light there
  // Upper limit of the spread with the mask, with two standard deviations, if the lamp is as smooth as the
  // surface.
  double spread_after_percent = 0;
};

// Returns the surface of the readings. Throws CalibrationRefused if a reading is not positive, above 1e9 or
// not on the display, there are fewer than nine or more than kMostLampReadings, they do not extend over three
// fifths of the display in at least three columns and three rows, scatter by more than 6 % or leave the light
// uncertain by more than 5 %, the surface is not a lamp's, or the mask would not make the light more even.
[[nodiscard]] LampFit fit_lamp(std::span<const LampReading> readings);

// Returns the uniformity mask of a display of that size: 255 where the surface is darkest, less where it is
// brighter. Throws std::invalid_argument as Mask does.
[[nodiscard]] Mask draw_uniformity_mask(const LampFit& lamp, Pixels width, Pixels height);

}  // namespace contourd
