// Exact places where lines through pixels' middles cross the surface of the models on the plate. Pure
// functions, thread-safe.
//
// Lines are vertical, one through each pixel's middle, or they run along the rows or the columns of pixels at
// chosen heights. Coordinates: x in columns and y in rows of pixels (pixel 0 covers 0 to 1), z in millimetres
// above the plate. Facets that share a side cross a line between them once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {

// A rectangle of pixels.
struct PixelWindow {
  std::int32_t column = 0, row = 0;  // the first ones
  std::int32_t columns = 0, rows = 0;
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

// Returns the pixels of the display on which models stand, with a margin; one pixel if there are none.
[[nodiscard]] PixelWindow window_of(std::span<const PlateModel> models, const DisplayGeometry& display,
                                    std::int32_t margin);

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

// Returns the crossings of the facets of all models with the lines, in no order. Throws what `check` throws.
// REQUIRES: no null pointers, fewer than 2^32 lines.
[[nodiscard]] std::vector<RayCrossing> cross_surface(std::span<const PlateModel> models, const Rays& rays,
                                                     StopCheck& check);

// A range of heights above the plate on vertical lines.
struct RayRange {
  double above_mm = 0, up_to_mm = 0;  // the lower end does not belong to it
};

// Returns the crossings at which vertical lines enter models within a range of heights. Looks at facets with
// a point there only. Ends with those found so far if the budget is overrun, or after an entry for each pixel
// of the window, and at most as many again. REQUIRES: no null pointers; the lower
// end is not above the upper.
[[nodiscard]] std::vector<RayCrossing> entries_between(std::span<const PlateModel> models,
                                                       const PixelWindow& window, const RayRange& range,
                                                       MaskBudget& budget);

// Returns the stretches within the models, by ray and from low to high: where more surfaces were entered than
// left. Stretches of no length are left out. Throws what `check` throws.
[[nodiscard]] std::vector<RayStretch> stretches_within(std::vector<RayCrossing> crossings, StopCheck& check);

}  // namespace contourd
