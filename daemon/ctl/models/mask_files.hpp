// The masks of all layers as PNG files, made by as many threads as the machine has processors, each with an
// engine of its own over the shared model. The files are the same however many threads there are.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/contour/layer_cracks.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/image/mask_png.hpp"

namespace contourd::ctl {

// Replaces the file. Throws OutputError when it cannot be written.
void write_mask(const std::filesystem::path& path, const Mask& mask);

// Writes 0001.png, 0002.png, ... into the folder, for layers cut at these heights above the plate. Blocks.
// The first layer that fails stops all; what it throws is thrown here: OutputError when its file cannot be
// written. `make_engine` is called on several threads at once. Returns what each layer's cracks cost.
std::vector<LayerCracks> write_masks(const std::filesystem::path& folder, std::span<const Nanometers> layers,
                                     const std::function<ContourEngine()>& make_engine);

}  // namespace contourd::ctl
