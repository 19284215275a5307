// Models of which nothing would be printed: smaller than a pixel, such as one drawn in metres, or taken away
// by their drain holes. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "core/engine/contour_engine.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct LightSearch {
  EngineSettings settings;
  std::span<const Nanometers> heights;
  std::uint8_t least_grey;  // of a pixel that cures; what the settings leave dark does not
  Duration mask_budget;
};
// Whether a pixel is so bright at one of the heights, by a copy of the model alone; true where a mask
// overruns its budget, or `stop` was asked for. Blocks: as a rule for one mask.
[[nodiscard]] bool lights_a_pixel(const PlateModel& model, const LightSearch& search,
                                  const std::stop_token& stop);

}  // namespace contourd
