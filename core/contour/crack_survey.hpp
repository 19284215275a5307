// Finds the layers of a cracked model whose contours cannot be closed without a guess (open or turned
// chains), before anything is printed. Makes no masks, and links only the sections that do not close by
// themselves. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/contour/layer_cracks.hpp"
#include "core/geometry/units.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

// A gap this many times as wide as the tolerance is no crack between facets: a part of the surface is
// missing.
inline constexpr double kWideGap = 10;

struct CrackSurvey {
  std::int32_t open_layers = 0;            // layers with at least one open or turned chain
  std::optional<std::int32_t> first_open;  // the first such layer, counted from 0
  std::int32_t wide_layers = 0;            // layers with a gap of more than kWideGap tolerances
  LayerCracks cracks;                      // the sum over all layers
};

// Surveys the layers. `heights`: the heights above the plate at which the layers are cut. Ends up to
// `tolerance` apart count as meeting.
[[nodiscard]] CrackSurvey survey_cracks(const StandingModel& model, std::span<const Nanometers> heights,
                                        Millimeters tolerance);

}  // namespace contourd
