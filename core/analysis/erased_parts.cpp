#include "core/analysis/erased_parts.hpp"

#include <algorithm>

#include "core/analysis/island_finder.hpp"
#include "core/mask/mask_runs.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostLayers = 200;

// Returns the layers that move inwards, or an even choice of them.
std::vector<std::int32_t> layers_to_compare(const ErasedPartSearch& search) {
  std::vector<std::int32_t> inwards, chosen;
  for (std::size_t layer = 0; layer < search.heights.size(); ++layer) {
    if (search.settings.compensation.offset_at(search.heights[layer]) < Micrometers{})
      inwards.push_back(static_cast<std::int32_t>(layer));
  }
  const std::size_t apart = (inwards.size() + kMostLayers - 1) / kMostLayers;
  for (std::size_t i = 0; i < inwards.size(); i += apart)
    chosen.push_back(inwards[i]);
  return chosen;
}

EngineSettings without_compensation(EngineSettings settings) {
  settings.compensation = {};
  return settings;
}

// The bright pixels of an engine's masks.
class BrightLayers {
 public:
  BrightLayers(const std::vector<PlateModel>& models, const EngineSettings& settings,
               const ErasedPartSearch& search)
      : engine_(models, settings),
        least_grey_(std::max(search.least_grey, engine_.threshold())),
        budget_(search.mask_budget) {}

  // Returns the bright pixels at a height, valid until the next call; null if the mask overran its budget.
  const MaskRuns* at(Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + budget_);
    if (engine_.mask_within(height, budget) == nullptr) return nullptr;
    lit_.extract(engine_.coverage());
    bright_.extract_bright(engine_.coverage(), lit_, least_grey_);
    return &bright_;
  }

 private:
  ContourEngine engine_;
  std::uint8_t least_grey_;
  std::chrono::nanoseconds budget_;
  MaskRuns lit_, bright_;
};

}  // namespace

ErasedParts find_erased_parts(const std::vector<PlateModel>& models, const ErasedPartSearch& search,
                              const std::stop_token& stop) {
  ErasedParts erased;
  const std::vector<std::int32_t> layers = layers_to_compare(search);
  if (layers.empty()) return erased;
  BrightLayers drawn(models, without_compensation(search.settings), search);
  BrightLayers printed(models, search.settings, search);
  const DisplayGeometry& display = search.settings.display;
  const double pitch_mm = to_millimeters(display.pixel_pitch).count();
  for (const std::int32_t layer : layers) {
    if (stop.stop_requested()) return erased;
    const Nanometers height = search.heights[static_cast<std::size_t>(layer)];
    const MaskRuns* const before = drawn.at(height);
    const MaskRuns* const after = printed.at(height);
    if (before == nullptr || after == nullptr) continue;
    const double moved_mm = -to_millimeters(search.settings.compensation.offset_at(height)).count();
    const double lost_mm = 2 * moved_mm + pitch_mm;
    // A part of the drawn layer that has nothing of the printed layer beneath it is an island.
    IslandFinder finder;
    for (const MaskIsland& part : finder.find(*before, *after, {1, 0}).here) {
      const double area_mm2 = static_cast<double>(part.grey) / 255 * pitch_mm * pitch_mm;
      if (area_mm2 <= lost_mm * lost_mm) continue;
      ++erased.count;
      if (!erased.largest || area_mm2 > erased.largest->area_mm2)
        erased.largest = ErasedPart{layer, on_plate(display, part.center), area_mm2};
    }
  }
  return erased;
}

}  // namespace contourd
