#include "daemon/dark_models.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace contourd {
namespace {

constexpr std::uint8_t kHalf = 128;

bool is_lit_by_half(const Mask& mask) {
  for (std::int32_t row = 0; row < mask.height().count(); ++row)
    if (std::ranges::max(mask.row(row)) >= kHalf) return true;
  return false;
}

}  // namespace

bool lights_a_pixel(const PlateModel& model, const EngineSettings& settings,
                    std::span<const Nanometers> heights, Duration mask_budget, const std::stop_token& stop) {
  PlateModel alone = model;
  alone.copies.resize(1, model.copies.front());
  ContourEngine engine(std::vector{std::move(alone)}, settings);
  return std::ranges::any_of(heights, [&](Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + mask_budget);
    return stop.stop_requested() || engine.mask_within(height, budget) == nullptr ||
           is_lit_by_half(engine.coverage());
  });
}

}  // namespace contourd
