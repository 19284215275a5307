// Models whose facet and segment counts can be chosen. Watertight to the bit. Thread-safe (no shared state).
#pragma once

#include "tests/models/models.hpp"

namespace contourd::bench {

struct PrismShape {
  int sides = 16;
  int bands = 1;  // the walls are divided into so many rings of equal height
  double radius_mm = 1;
  double height_mm = 1;
};

// A regular prism around (x, y), standing on z = 0: 2 sides (bands + 1) facets. A plane strictly inside a
// band crosses 2 facets for each side.
[[nodiscard]] models::Facets prism(const PrismShape& shape, double x_mm, double y_mm);

// `count` prisms of 16 sides, each in a square millimetre of its own, spread evenly over kFieldColumns by
// kFieldRows of them: 32 segments a prism, of the same shape whatever the count.
// REQUIRES: 0 < count <= kFieldColumns * kFieldRows.
inline constexpr int kFieldColumns = 48, kFieldRows = 27;
[[nodiscard]] models::Facets field_of_prisms(int count);

}  // namespace contourd::bench
