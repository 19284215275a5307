// Writes the masks of all layers as PNG files. Uses one thread per processor, each with its own engine for
// the shared model. The files do not depend on the number of threads.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/contour/layer_cracks.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/image/mask_png.hpp"

namespace contourd::ctl {

// Writes or replaces the file. Throws OutputError.
void write_mask(const std::filesystem::path& path, const Mask& mask);

// Writes 0001.png, 0002.png, ... into the folder, for layers cut at these heights above the plate. Blocks. If
// a layer fails, stops and throws the exception of the lowest failed layer: OutputError if its file cannot be
// written. `make_engine` is called on several threads at once. Returns the cracks of each layer.
std::vector<LayerCracks> write_masks(const std::filesystem::path& folder, std::span<const Nanometers> layers,
                                     const std::function<ContourEngine()>& make_engine);

}  // namespace contourd::ctl
