#include "core/hollow/infill_struts.hpp"

#include <cmath>

namespace contourd {
namespace {

// Returns the distance, with its sign, from the nearest multiple of a period.
double from_nearest(double value, double period) {
  return value - period * std::floor(value / period + 0.5);
}

}  // namespace

void InfillStruts::begin(std::int32_t slice) {
  z_ = grid_.bottom_of(slice) + grid_.cell_mm / 2;
}

// A strut along (a, b, 1), a and b 1 or -1, crosses z = 0 in whole multiples of the cell's side. Its section
// is an ellipse, the root of 3 times as long along (a, b) as across.
bool InfillStruts::fills(std::int32_t column, std::int32_t row) const {
  const double x = grid_.left_of(column) + grid_.cell_mm / 2, y = grid_.top_of(row) - grid_.cell_mm / 2;
  const double cell = lattice_.cell.count(), radius = lattice_.strut.count() / 2;
  for (const double a : {1.0, -1.0}) {
    for (const double b : {1.0, -1.0}) {
      const double dx = from_nearest(x - a * z_, cell), dy = from_nearest(y - b * z_, cell);
      const double along = (dx * a + dy * b) * std::sqrt(0.5), across = (dx * b - dy * a) * std::sqrt(0.5);
      if (along * along / 3 + across * across <= radius * radius) return true;
    }
  }
  return false;
}

}  // namespace contourd
