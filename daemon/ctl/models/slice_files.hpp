// Writes the thesis's measurements and contours as CSV files. All functions throw OutputError if a file
// cannot be written.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "core/contour/contour_loops.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd::ctl {

// Writes or replaces the file.
void write_text(const std::filesystem::path& path, std::string_view text);

// Writes a heading, and one row per layer (thesis, section 3.5).
void write_measurements(const std::filesystem::path& path, std::span<const LayerMeasurement> layers);

// Writes one row per measurement: mean and standard deviation (tables 4.1 to 4.6); then the correlations of
// table 4.5.
void write_statistics(const std::filesystem::path& path, const LayerStatistics& statistics);

// Writes one row per point: its loop, and its positions in the model and on the display.
void write_contours(const std::filesystem::path& path, const Contours& contours, const PixelMap& map);

}  // namespace contourd::ctl
