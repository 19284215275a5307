// Lines through pixels' middles, and the stretches of them within a model. Values; thread-safe as any value
// is.
//
// Lines are vertical, one through each pixel's middle, or they run along the rows or the columns of pixels at
// chosen heights. Coordinates: x in columns and y in rows of pixels (pixel 0 covers 0 to 1), z in millimetres
// above the plate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace contourd {

// A rectangle of pixels.
struct PixelWindow {
  std::int32_t column = 0, row = 0;  // the first ones
  std::int32_t columns = 0, rows = 0;
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

enum class RayAxis : std::uint8_t { X, Y, Z };

// The lines that are followed. Vertical ones have the number column + row * window.columns, within the
// window; those along the rows row + height * window.rows, those along the columns
// column + height * window.columns.
struct Rays {
  RayAxis axis = RayAxis::Z;
  PixelWindow window{};
  std::vector<double> heights_mm{};  // rising; of lines along x or y
};

struct RayCrossing {
  std::uint32_t ray;
  float at;         // coordinate along the line
  float steepness;  // share of the surface's unit normal along the line: -1 where the line enters at a right
                    // angle, +1 where it leaves so
};

// A stretch of a line within a model.
struct RayStretch {
  std::uint32_t ray;
  RayCrossing from, to;
};

}  // namespace contourd
