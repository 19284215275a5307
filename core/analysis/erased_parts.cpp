#include "core/analysis/erased_parts.hpp"

#include <algorithm>

#include "core/analysis/island_finder.hpp"
#include "core/mask/mask_runs.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostLayers = 200;
// The number of small parts that are looked at in a layer: a mesh of noise has thousands.
constexpr std::size_t kMostThin = 64;

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

// The lit pixels of an engine's masks.
class LitPixels {
 public:
  LitPixels(const std::vector<PlateModel>& models, const EngineSettings& settings,
            const ErasedPartSearch& search)
      : engine_(models, settings),
        least_grey_(std::max(search.least_grey, engine_.threshold())),
        budget_(search.mask_budget) {}

  // Returns the lit pixels at a height, faint ones too, valid until the next call; null if the mask overran
  // its budget.
  const MaskRuns* at(Nanometers height) {
    MaskBudget budget(MaskBudget::Clock::now() + budget_);
    if (engine_.mask_within(height, budget) == nullptr) return nullptr;
    lit_.extract(engine_.coverage());
    return &lit_;
  }
  // Returns the pixels that cure, with the same conditions.
  const MaskRuns* curing_at(Nanometers height) {
    if (at(height) == nullptr) return nullptr;
    bright_.extract_bright(engine_.coverage(), lit_, least_grey_);
    return &bright_;
  }

 private:
  ContourEngine engine_;
  std::uint8_t least_grey_;
  std::chrono::nanoseconds budget_;
  MaskRuns lit_, bright_;
};

class ErasedPartFinder {
 public:
  ErasedPartFinder(const std::vector<PlateModel>& models, const ErasedPartSearch& search)
      : search_(search),
        drawn_(models, without_compensation(search.settings), search),
        printed_(models, search.settings, search),
        pitch_mm_(to_millimeters(search.settings.display.pixel_pitch).count()) {}

  void look_at(std::int32_t layer) {
    const Nanometers height = search_.heights[static_cast<std::size_t>(layer)];
    const double moved_mm = -to_millimeters(search_.settings.compensation.offset_at(height)).count();
    const double point_mm = 2 * moved_mm + pitch_mm_;
    std::vector<MaskIsland> thin;
    for (const MaskIsland& part : parts_at(height)) {
      if (area_of(part) > point_mm * point_mm) {
        note(part, layer);
      } else {
        thin.push_back(part);
      }
    }
    if (thin.empty()) return;
    thin.resize(std::min(thin.size(), kMostThin));
    // A pin goes on beneath and above; the end of a point widens soon. The plate ends a pin as well.
    const std::vector<MaskIsland> beneath = height < kPinHalf ? thin : parts_at(height - kPinHalf);
    const std::vector<MaskIsland> above = parts_at(height + kPinHalf);
    for (const MaskIsland& part : thin)
      if (is_near(part, beneath) && is_near(part, above)) note(part, layer);
  }
  [[nodiscard]] const ErasedParts& erased() const { return erased_; }

 private:
  static constexpr Nanometers kPinHalf{200'000};  // half the height of the lowest pin that counts

  [[nodiscard]] double area_of(const MaskIsland& part) const {
    return static_cast<double>(part.grey) / 255 * pitch_mm_ * pitch_mm_;
  }

  // Returns the parts of the drawn layer that have no curing pixel left.
  std::vector<MaskIsland> parts_at(Nanometers height) {
    const MaskRuns* const drawn = drawn_.at(height);
    const MaskRuns* const printed = printed_.curing_at(height);
    if (drawn == nullptr || printed == nullptr) return {};
    // A part that has nothing of the printed layer beneath it is an island.
    IslandFinder finder;
    const std::span<const MaskIsland> parts = finder.find(*drawn, *printed, {1, 0}).here;
    return {parts.begin(), parts.end()};
  }

  [[nodiscard]] bool is_near(const MaskIsland& part, const std::vector<MaskIsland>& others) const {
    const double pixels = to_millimeters(kPinHalf).count() / pitch_mm_;
    return std::ranges::any_of(others, [&](const MaskIsland& other) {
      return part.left - other.right <= pixels && other.left - part.right <= pixels &&
             part.top - other.bottom <= pixels && other.top - part.bottom <= pixels;
    });
  }

  void note(const MaskIsland& part, std::int32_t layer) {
    ++erased_.count;
    if (!erased_.largest || area_of(part) > erased_.largest->area_mm2)
      erased_.largest = ErasedPart{layer, on_plate(search_.settings.display, part.center), area_of(part)};
  }

  const ErasedPartSearch& search_;
  LitPixels drawn_, printed_;
  double pitch_mm_;
  ErasedParts erased_;
};

}  // namespace

ErasedParts find_erased_parts(const std::vector<PlateModel>& models, const ErasedPartSearch& search,
                              const std::stop_token& stop) {
  const std::vector<std::int32_t> layers = layers_to_compare(search);
  if (layers.empty()) return {};
  ErasedPartFinder finder(models, search);
  for (const std::int32_t layer : layers) {
    if (stop.stop_requested()) break;
    finder.look_at(layer);
  }
  return finder.erased();
}

}  // namespace contourd
