#include "core/cure/cured_part.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/support/support_mesh.hpp"

namespace contourd {
namespace {

// The masks of a print, as the share of the light that they are to give.
class PrintMasks {
 public:
  PrintMasks(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
             std::optional<std::chrono::nanoseconds> budget)
      : engine_(engine),
        light_(light),
        dimmed_(light.undersides != nullptr ? light.layers.size() : 0),
        threshold_({.threshold = engine.threshold()}, std::nullopt),
        changed_(display.width, display.height),
        budget_(budget) {
    for (std::size_t layer = 0; layer < dimmed_.size(); ++layer) {
      const std::span<const DimmedPixel> pixels = light.undersides->dimmed(layer);
      dimmed_[layer].assign(pixels.begin(), pixels.end());
      unfound_ += light.undersides->are_found(layer) ? 0 : 1;
    }
  }

  // Returns the number of layers in which undersides were not found within their budget.
  [[nodiscard]] std::int64_t unfound() const { return unfound_; }
  // Returns the mask of a layer; null if it exceeded its budget. Valid until the next call.
  const Mask* of(std::size_t number) {
    const LayerDose& layer = light_.layers[number];
    MaskBudget budget;
    if (budget_) budget = MaskBudget(MaskBudget::Clock::now() + *budget_);
    if (engine_.mask_within(layer.top - layer.thickness + layer.thickness / 2, budget) == nullptr)
      return nullptr;
    if (threshold_.is_none() && dimmed_.empty()) return &engine_.coverage();
    threshold_.apply(engine_.coverage(), changed_);
    if (!dimmed_.empty()) dim(dimmed_[number], changed_);
    return &changed_;
  }

 private:
  ContourEngine& engine_;
  const PrintLight& light_;
  std::vector<std::vector<DimmedPixel>> dimmed_;  // by layer; none without dimming
  std::int64_t unfound_ = 0;
  ExposureCorrection threshold_;
  Mask changed_;
  std::optional<std::chrono::nanoseconds> budget_;
};

// Grows to the pixels of masks.
class GrowingWindow {
 public:
  GrowingWindow(const PixelWindow& least, const DisplayGeometry& display)
      : width_(display.width.count()),
        height_(display.height.count()),
        left_(least.column),
        top_(least.row),
        right_(least.column + least.columns),
        bottom_(least.row + least.rows) {}

  void add(const Mask& mask, std::int32_t margin) {
    for (std::int32_t y = 0; y < height_; ++y) {
      const auto row = mask.row(y);
      const auto is_lit = [](std::uint8_t grey) { return grey > 0; };
      const auto first = std::ranges::find_if(row, is_lit);
      if (first == row.end()) continue;
      const auto last = std::find_if(row.rbegin(), row.rend(), is_lit);
      const auto from = static_cast<std::int32_t>(first - row.begin());
      const auto to = width_ - static_cast<std::int32_t>(last - row.rbegin());
      left_ = std::min(left_, std::max(0, from - margin));
      right_ = std::max(right_, std::min(width_, to + margin));
      top_ = std::min(top_, std::max(0, y - margin));
      bottom_ = std::max(bottom_, std::min(height_, y + 1 + margin));
    }
  }

  [[nodiscard]] PixelWindow window() const { return {left_, top_, right_ - left_, bottom_ - top_}; }

 private:
  std::int32_t width_, height_, left_, top_, right_, bottom_;
};

std::vector<PlateModel> as_models(const Supports* supports, const DisplayGeometry& display) {
  if (supports == nullptr || !supports->structure) return {};
  HeightIndex mesh(support_mesh(supports->structure->primitives()));
  const Nanometers lowest = to_nanometers(Millimeters{mesh.bounds().min_z}).value_or(Nanometers{});
  PlateModel model{{std::make_shared<const HeightIndex>(std::move(mesh)), Elevation(lowest)},
                   {PixelMap::true_scale(display, {0, 0})}};
  std::vector<PlateModel> models;
  models.push_back(std::move(model));
  return models;
}

void read_light(const Mask& mask, const PixelWindow& window, std::span<float> light) {
  auto to = light.begin();
  for (std::int32_t y = window.row; y < window.row + window.rows; ++y) {
    const auto row = mask.row(y).subspan(static_cast<std::size_t>(window.column),
                                         static_cast<std::size_t>(window.columns));
    to = std::ranges::transform(row, to, [](std::uint8_t grey) {
           return static_cast<float>(grey) / 255.0F;
         }).out;
  }
}

void find_weakest_bond(const PrintLight& light, CuredPart& part) {
  const double depth_mm = to_millimeters(light.cure.curve.penetration_depth).count();
  const double dead_zone_mm = to_millimeters(light.cure.dead_zone).count();
  for (std::size_t layer = 1; layer < light.layers.size(); ++layer) {
    const LayerDose& of = light.layers[layer];
    const double bond =
        of.dose / light.cure.curve.critical_dose * std::exp(-(in_mm(of.thickness) + dead_zone_mm) / depth_mm);
    if (layer > 1 && bond >= part.weakest_bond) continue;
    part.weakest_bond = bond;
    part.weakest_bond_layer = static_cast<std::int32_t>(layer);
  }
}

}  // namespace

CuredPart cure_part(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
                    const Supports* supports, std::optional<std::chrono::nanoseconds> mask_budget) {
  PrintMasks masks(engine, display, light, mask_budget);
  const std::int32_t margin = light.pixel.reach() + 1;  // one more, so that walls have an outside
  GrowingWindow grown(window_of(engine.models(), display, margin), display);
  for (std::size_t layer = 0; layer < light.layers.size(); ++layer)
    if (const Mask* mask = masks.of(layer)) grown.add(*mask, margin);
  const PixelWindow window = grown.window();
  const std::vector<PlateModel> support_models = as_models(supports, display);
  CureComparison comparison(engine.models(), support_models, display, window, light.layers);
  CuredLayers cured(light.cure, window.pixels());
  LightSpread spread(light.pixel, static_cast<std::size_t>(window.columns),
                     static_cast<std::size_t>(window.rows));
  std::vector<float> share(window.pixels());
  CuredPart part;
  part.unfound_undersides = masks.unfound();
  for (std::size_t layer = light.layers.size(); layer-- > 0;) {
    if (const Mask* mask = masks.of(layer)) {
      read_light(*mask, window, share);
    } else {
      std::ranges::fill(share, 0.0F);
      ++part.abandoned_layers;
    }
    spread.apply(share);
    comparison.add_layer(layer, cured, cured.add_layer(light.layers[layer], share));
  }
  part.figures = comparison.figures();
  find_weakest_bond(light, part);
  return part;
}

}  // namespace contourd
