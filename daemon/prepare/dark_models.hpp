// Finds models of which nothing would be printed: smaller than a pixel, for instance drawn in metres, or
// removed completely by their drain holes. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "core/engine/contour_engine.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Heights and limits of a search for a bright pixel.
struct LightSearch {
  EngineSettings settings;
  std::span<const Nanometers> heights;
  std::uint8_t least_grey;  // lowest grey value that cures; the tone threshold of the settings may raise it
  Duration mask_budget;     // for each mask
};
// True if one copy of the model, alone on the plate, lights a pixel brightly enough at one of the heights.
// Also true if a mask overruns its budget or `stop` is requested. Blocks, usually for one mask.
[[nodiscard]] bool lights_a_pixel(const PlateModel& model, const LightSearch& search,
                                  const std::stop_token& stop);

}  // namespace contourd
