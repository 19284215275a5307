// The files that commands about models write: single files, and folders with one file per layer: 0001.png,
// 0002.png and so on. All functions throw OutputError if a file cannot be written. Thread-safe (no shared
// state).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/light_split.hpp"

namespace contourd::ctl {

// Write or replace the file.
void write_text(const std::filesystem::path& path, std::string_view text);
void write_mask(const std::filesystem::path& path, const Mask& mask);

// Returns the name of a layer's file; layers are counted from 1.
[[nodiscard]] std::string layer_file(std::size_t layer, std::string_view extension);

// The treatment of an earlier slice's files. They cannot stay: files after the last new layer would look like
// layers of this model.
enum class Earlier { Refuse, Replace };

// Makes the folder and removes an earlier slice's files from it; other files stay. Throws OutputError if this
// fails, or if there are such files and `earlier` is Refuse; then nothing is changed.
void open_layer_folder(const std::filesystem::path& folder, std::string_view extension, Earlier earlier);

// Makes masks of layers, on one thread.
struct MaskMaker {
  ContourEngine engine;
  std::unique_ptr<DimmedMasks> undersides{};  // null: they are exposed plainly
  std::unique_ptr<GivenLight> given{};        // null: exposures are not split
};

// Writes 0001.png, 0002.png, ... into the folder, for layers cut at these heights above the plate. Uses one
// thread per processor, each with a maker of its own for the shared model; the files do not depend on the
// number of threads. Blocks. If a layer fails, stops and throws the exception of the lowest failed layer.
// `make_maker` is called on several threads at once. Returns the cracks of each layer.
std::vector<LayerCracks> write_masks(const std::filesystem::path& folder, std::span<const Nanometers> layers,
                                     const std::function<MaskMaker()>& make_maker);

// Writes one row per point: its loop, and its positions in the model and on the display.
void write_contours(const std::filesystem::path& path, const Contours& contours, const PixelMap& map);

}  // namespace contourd::ctl
