// Settings in PrusaSlicer's words, for files that it and tools like it read. Thread-safe (no shared state).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

// Keys and values, in the order of the file.
using SlicerSettings = std::vector<std::pair<std::string, std::string>>;

// Returns the settings of a display: pixels, size and mirrors.
[[nodiscard]] SlicerSettings display_settings(const DisplayGeometry& display);

// The layers of a print, as PrusaSlicer knows them.
struct SlicerLayers {
  Nanometers height{};
  Duration exposure{}, first_exposure{};
  int fading_layers = 0;
};
// Returns the settings of these layers.
[[nodiscard]] SlicerSettings layer_settings(const SlicerLayers& layers);

// Return numbers as PrusaSlicer writes them: a length in millimetres, a time in seconds.
[[nodiscard]] std::string slicer_mm(Nanometers length);
[[nodiscard]] std::string slicer_seconds(Duration time);

// Returns the settings as lines "key = value".
[[nodiscard]] std::string ini_text(const SlicerSettings& settings);

}  // namespace contourd::ctl
