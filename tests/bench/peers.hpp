// Other slicers, run as whole processes where they are installed. Blocks while they run.
#pragma once

#include <filesystem>
#include <optional>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "tests/bench/report.hpp"

namespace contourd::bench {

// Debian's slic3r: the contours of all layers, to SVG. Nothing when it is not installed.
[[nodiscard]] std::optional<Peer> run_slic3r(const std::filesystem::path& model, Nanometers layer);

// Debian's prusa-slicer: all masks, supports and pad off, to an .sl1 archive of PNG files. In seconds.
// Nothing when it is not installed.
[[nodiscard]] std::optional<Peer> run_prusa_slicer(const std::filesystem::path& model, Nanometers layer,
                                                   const DisplayGeometry& display);

}  // namespace contourd::bench
