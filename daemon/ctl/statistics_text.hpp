// The thesis's statistics of a sliced model (tables 4.1 to 4.6), printed for a person or as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "core/layer_statistics.hpp"

namespace contourd::ctl {

void print_statistics(const LayerStatistics& statistics);
[[nodiscard]] nlohmann::ordered_json statistics_json(const LayerStatistics& statistics);

}  // namespace contourd::ctl
