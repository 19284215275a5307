// Finds room for rectangles on the plate, in whole pixels, so that what stands on the pixel grid stays on it.
// A value; not thread-safe while it is changed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/units.hpp"

namespace contourd {

// In grid lines from the plate's left front corner.
struct PlateRectangle {
  std::int64_t left = 0, front = 0, width = 0, depth = 0;
  bool operator==(const PlateRectangle&) const = default;
};

// The largest free rectangles are kept, as in Jylanki's MAXRECTS: "A Thousand Ways to Pack the Bin", 2010.
class PlatePacking {
 public:
  // Rectangles keep `gap` between each other; none is kept to the plate's edges.
  PlatePacking(Pixels width, Pixels depth, Pixels gap);

  // Takes a place, whether it is free or not and whether it is on the plate or not.
  void occupy(const PlateRectangle& rectangle);

  // Takes the free place that is farthest to the front, then to the left; nothing when there is none.
  // REQUIRES: width and depth > 0.
  [[nodiscard]] std::optional<PlateRectangle> find_room(std::int64_t width, std::int64_t depth);

 private:
  std::int64_t gap_;
  std::vector<PlateRectangle> free_;  // each with a gap's width more at its right and back
};

}  // namespace contourd
