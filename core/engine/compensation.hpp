// The distance by which a print's contours are moved so that the cured part has the model's size: scattered
// light cures more than the lit area, most of all in the layers on the plate. A value; thread-safe as any
// value is.
#pragma once

#include <algorithm>

#include "core/geometry/units.hpp"

namespace contourd {

struct Compensation {
  // Outwards at every height; negative shrinks. A negative value compensates over-cure, which makes parts too
  // large.
  Micrometers growth{};
  // Elephant foot: inwards in addition, in full at the plate, fading linearly to 0 at elephant_foot_height.
  Micrometers elephant_foot{};
  Nanometers elephant_foot_height{};

  // Returns the distance outwards for the section at a height above the plate.
  [[nodiscard]] Micrometers offset_at(Nanometers height) const {
    if (elephant_foot == Micrometers{} || height >= elephant_foot_height) return growth;
    const auto faded = static_cast<double>(std::max(height, Nanometers{0}).count());
    return growth - elephant_foot * (1.0 - faded / static_cast<double>(elephant_foot_height.count()));
  }

  bool operator==(const Compensation&) const = default;
};

}  // namespace contourd
