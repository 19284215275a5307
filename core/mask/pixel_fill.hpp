// The part of a pixel that overlapping polygons fill together: the area in which the winding number is not 0.
//
// The pixel is cut into strips at every height where a side begins, ends, enters the pixel, or crosses
// another. Within a strip no two sides cross, so the area between two neighbours is their mean distance times
// the strip's height. The sides give the winding numbers in the pixel but for a whole number that all points
// share, which follows from the pixel's mean winding number. Not thread-safe; allocates only while the number
// of sides grows.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace contourd {

// A part of a side within a pixel, from the top down. Coordinates are 0 to 1 from the pixel's upper left
// corner.
struct PixelSide {
  double top_x, top_y, bottom_y;
  double slope;  // columns for each unit of height
  int sign;      // +1 if the side runs downwards, -1 if upwards

  [[nodiscard]] double x_at(double y) const { return top_x + slope * (y - top_y); }
};

// A place where a side, also a level one, crosses the left edge of the pixel.
struct EdgeCrossing {
  double y;
  int change;  // winding number on the edge below the place, minus that above it
};

class PixelFill {
 public:
  // Limit on the sides: the time grows with the third power of their number.
  static constexpr std::size_t kMostSides = 64;

  // Returns the filled part of the pixel, 0 to 1; nothing if the sides contradict the mean winding number,
  // which happens only where a side's rounding has put a piece of it into a wrong pixel. REQUIRES: at most
  // kMostSides sides, and as many crossings.
  [[nodiscard]] std::optional<double> filled(std::span<const PixelSide> sides,
                                             std::span<const EdgeCrossing> crossings, double mean_winding);

 private:
  struct Passed {
    double x;
    int sign;
  };

  void find_heights(std::span<const PixelSide> sides, std::span<const EdgeCrossing> crossings);
  [[nodiscard]] double filled_width(std::span<const PixelSide> sides, double top, double bottom, int winding);

  std::vector<double> heights_;
  std::vector<Passed> passed_;  // sides of a strip, from left to right
};

}  // namespace contourd
