// Models with selectable numbers of facets and segments. Watertight to the bit. Thread-safe (no shared
// state).
#pragma once

#include "tests/models/models.hpp"

namespace contourd::bench {

struct PrismShape {
  int sides = 16;
  int bands = 1;  // number of rings of equal height into which the walls are divided
  double radius_mm = 1;
  double height_mm = 1;
};

// Returns a regular prism around (x, y), standing on z = 0: 2 sides (bands + 1) facets. A plane strictly
// inside a band crosses 2 facets for each side.
[[nodiscard]] models::Facets prism(const PrismShape& shape, double x_mm, double y_mm);

inline constexpr int kFieldColumns = 48, kFieldRows = 27;
// Returns `count` prisms of 16 sides, each in its own square millimetre, spread evenly over kFieldColumns by
// kFieldRows squares: 32 segments a prism, of the same shape for every count.
// REQUIRES: 0 < count <= kFieldColumns * kFieldRows.
[[nodiscard]] models::Facets field_of_prisms(int count);

}  // namespace contourd::bench
