// Runs other slicers as whole processes, if they are installed. Blocks while they run.
#pragma once

#include <filesystem>
#include <optional>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "tests/bench/report.hpp"

namespace contourd::bench {

// Runs Debian's slic3r: the contours of all layers, to SVG. Returns nullopt if it is not installed.
[[nodiscard]] std::optional<Peer> run_slic3r(const std::filesystem::path& model, Nanometers layer);

// Runs Debian's prusa-slicer: all masks, with supports and pad off, to an .sl1 archive of PNG files. The
// figure is in seconds. Returns nullopt if it is not installed.
[[nodiscard]] std::optional<Peer> run_prusa_slicer(const std::filesystem::path& model, Nanometers layer,
                                                   const DisplayGeometry& display);

}  // namespace contourd::bench
