// The shrinkage and the growth of a resin's parts, from measured lengths. Values and pure functions;
// thread-safe.
//
// A part is printed with the profile's own compensation, and measures scale * drawn + 2 * growth from outer
// side to outer side, scale * drawn - 2 * growth in a gap. From the scale along each axis and the growth
// follow the compensations with which the next part measures what is drawn.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/calibration/line_fit.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

enum class LengthKind {
  Outer,  // of material
  Inner,  // of a gap or hole
};
enum class PlateAxis { X, Y };

struct MeasuredLength {
  PlateAxis axis{};
  LengthKind kind{};
  Millimeters drawn{}, measured{};
};

// Compensations of a resin's profile.
struct DimensionSettings {
  double shrinkage_x_percent = 0, shrinkage_y_percent = 0;
  double growth_um = 0;
};

// The values of the profile with which parts have their drawn size.
struct DimensionFit {
  std::optional<Estimate> shrinkage_x_percent, shrinkage_y_percent;  // for the axes that were measured
  Estimate growth_um;
  double scatter_um = 0;               // lengths about those by scale and growth
  std::vector<Estimate> lengths_mm{};  // by scale and growth, in the order of the measured ones
};

// Returns the fit of a part that was printed with `printed`. `reading` is the standard uncertainty of a
// length by the rounding of its readings, the least that is assumed. Throws CalibrationRefused if a length is
// not positive, is more than a fifth and 1 mm off, there are fewer than three lengths for each figure or too
// similar ones, the lengths scatter by more than 60 um, the figures are too uncertain or outside of their
// limits in a profile.
[[nodiscard]] DimensionFit fit_dimensions(const DimensionSettings& printed,
                                          std::span<const MeasuredLength> measured, Millimeters reading = {});

}  // namespace contourd
