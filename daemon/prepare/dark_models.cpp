#include "daemon/prepare/dark_models.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace contourd {
namespace {

bool has_bright_pixel(const Mask& mask, std::uint8_t least_grey) {
  for (std::int32_t row = 0; row < mask.height().count(); ++row)
    if (std::ranges::max(mask.row(row)) >= least_grey) return true;
  return false;
}

}  // namespace

bool lights_a_pixel(const PlateModel& model, const LightSearch& search, const std::stop_token& stop) {
  PlateModel alone = model;
  alone.copies.resize(1, model.copies.front());
  ContourEngine engine(std::vector{std::move(alone)}, search.settings);
  const std::uint8_t least_grey = std::max(search.least_grey, engine.threshold());
  return std::ranges::any_of(search.heights, [&](Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + search.mask_budget);
    return stop.stop_requested() || engine.mask_within(height, budget) == nullptr ||
           has_bright_pixel(engine.coverage(), least_grey);
  });
}

}  // namespace contourd
