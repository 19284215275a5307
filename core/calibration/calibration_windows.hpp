// Pictures of windows for calibration prints on the bare film. Pure functions; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

inline constexpr std::size_t kMostWindows = 9;

// Draws up to nine windows in rows of three around the middle of a display, the first at top left, each 6 mm
// wide (less on a display below 40 mm) with as many dots beneath it as its number: film and resin are looked
// at from either side. A window and its dots have the window's grey value; 0 keeps both dark. REQUIRES: one
// to kMostWindows windows, a display of at least 100 pixels on each side, a pitch above 0.
[[nodiscard]] Mask draw_calibration_windows(std::span<const std::uint8_t> greys, Pixels width, Pixels height,
                                            Micrometers pitch);

}  // namespace contourd
