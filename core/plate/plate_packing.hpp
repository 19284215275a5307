// Finds room for rectangles on the plate. All sizes are whole pixels, so that models on the pixel grid stay
// on it. A value; not thread-safe while it is changed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/units.hpp"

namespace contourd {

// A rectangle on the pixel grid, in pixels from the plate's left front corner.
struct PlateRectangle {
  std::int64_t left = 0, front = 0, width = 0, depth = 0;
  bool operator==(const PlateRectangle&) const = default;
};

// A packing that keeps the largest free rectangles, as in Jylanki's MAXRECTS: "A Thousand Ways to Pack the
// Bin", 2010.
class PlatePacking {
 public:
  // Keeps `gap` between rectangles, but none to the plate's edges.
  PlatePacking(Pixels width, Pixels depth, Pixels gap);

  // Marks the rectangle as occupied, even if it is occupied already or lies off the plate.
  void occupy(const PlateRectangle& rectangle);

  // Occupies and returns the free place that is farthest to the front, then to the left; nullopt if there is
  // none. REQUIRES: width and depth > 0.
  [[nodiscard]] std::optional<PlateRectangle> find_room(std::int64_t width, std::int64_t depth);

 private:
  std::int64_t gap_;
  std::vector<PlateRectangle> free_;  // each larger by the gap at its right and back
};

}  // namespace contourd
