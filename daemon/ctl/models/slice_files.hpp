// The files that contourctl writes: the thesis's measurements and contours as CSV. Throws OutputError
// when one cannot be written.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "core/contour/contour_loops.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd::ctl {

// Replaces the file.
void write_text(const std::filesystem::path& path, std::string_view text);

// One row a layer (thesis, section 3.5), under a heading.
void write_measurements(const std::filesystem::path& path, std::span<const LayerMeasurement> layers);

// One row a measurement: mean and standard deviation (tables 4.1 to 4.6), then table 4.5's correlations.
void write_statistics(const std::filesystem::path& path, const LayerStatistics& statistics);

// One row a point: its loop, and where it is in the model and on the display.
void write_contours(const std::filesystem::path& path, const Contours& contours, const PixelMap& map);

}  // namespace contourd::ctl
