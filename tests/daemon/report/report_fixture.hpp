// Helpers shared by the tests of print reports.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// Returns an engine for a box of 3 x 2 x 1 mm in the middle of a display of 64 x 48 pixels of 0.1 mm. `lift`
// is the height of the box above the plate; a mirrored display is mirrored in both directions.
[[nodiscard]] inline ContourEngine engine_of_a_box(bool mirrored = false, Nanometers lift = {}) {
  const DisplayGeometry display{Pixels{64}, Pixels{48}, Micrometers{100.0}, mirrored, mirrored};
  const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {3, 2, 1})),
                          Elevation(lift)};
  return {std::vector{PlateModel{box, {PixelMap::true_scale(display, {1.5, 1})}}},
          EngineSettings{.display = display}};
}

// Returns the number of occurrences of `what` in the text, overlapping ones included.
[[nodiscard]] inline std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++found;
  return found;
}

}  // namespace contourd::testing
