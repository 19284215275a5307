// How far a print's contours are moved so that the cured part has the model's size: light that scatters cures
// more than it lights, and the layers on the plate get the most of it. A value; thread-safe as any value is.
#pragma once

#include <algorithm>

#include "core/geometry/units.hpp"

namespace contourd {

struct Compensation {
  // Outwards at every height; negative shrinks. Over-cure that makes parts too large takes a negative one.
  Micrometers growth{};
  // Elephant foot: inwards in addition, in full at the plate, fading linearly to nothing at the height.
  Micrometers elephant_foot{};
  Nanometers elephant_foot_height{};

  // Outwards, for the section at a height above the plate.
  [[nodiscard]] Micrometers offset_at(Nanometers height) const {
    if (elephant_foot == Micrometers{} || height >= elephant_foot_height) return growth;
    const auto gone = static_cast<double>(std::max(height, Nanometers{0}).count());
    return growth - elephant_foot * (1.0 - gone / static_cast<double>(elephant_foot_height.count()));
  }

  bool operator==(const Compensation&) const = default;
};

}  // namespace contourd
