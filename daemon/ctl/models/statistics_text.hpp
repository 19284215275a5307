// The thesis's statistics of a sliced model (tables 4.1 to 4.6) as text or JSON, and its layers as text.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "core/layers/layer_statistics.hpp"

namespace contourd::ctl {

void print_statistics(const LayerStatistics& statistics);
[[nodiscard]] nlohmann::ordered_json statistics_json(const LayerStatistics& statistics);

// Returns text such as "400 of 50 um" or "372 of 25 to 100 um".
[[nodiscard]] std::string layers_text(std::span<const Nanometers> thicknesses);

}  // namespace contourd::ctl
