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
  PrintMasks(ContourEngine& engine, const DisplayGeometry& display,
             std::optional<std::chrono::nanoseconds> budget)
      : engine_(engine),
        threshold_({.threshold = engine.threshold()}, std::nullopt),
        above_threshold_(display.width, display.height),
        budget_(budget) {}

  // Returns the mask of a layer; null if it exceeded its budget. Valid until the next call.
  const Mask* of(const LayerDose& layer) {
    MaskBudget budget;
    if (budget_) budget = MaskBudget(MaskBudget::Clock::now() + *budget_);
    if (engine_.mask_within(layer.top - layer.thickness + layer.thickness / 2, budget) == nullptr)
      return nullptr;
    if (threshold_.is_none()) return &engine_.coverage();
    threshold_.apply(engine_.coverage(), above_threshold_);
    return &above_threshold_;
  }

 private:
  ContourEngine& engine_;
  ExposureCorrection threshold_;
  Mask above_threshold_;
  std::optional<std::chrono::nanoseconds> budget_;
};

// Grows to the pixels of models and masks.
class GrowingWindow {
 public:
  GrowingWindow(const DisplayGeometry& display, std::int32_t margin)
      : margin_(margin), width_(display.width.count()), height_(display.height.count()) {}

  void add(const Mask& mask) {
    for (std::int32_t y = 0; y < height_; ++y) {
      const auto row = mask.row(y);
      const auto is_lit = [](std::uint8_t grey) { return grey > 0; };
      const auto first = std::ranges::find_if(row, is_lit);
      if (first == row.end()) continue;
      const auto last = std::find_if(row.rbegin(), row.rend(), is_lit);
      left_ = std::min(left_, static_cast<std::int32_t>(first - row.begin()));
      right_ = std::max(right_, width_ - static_cast<std::int32_t>(last - row.rbegin()));
      top_ = std::min(top_, y);
      bottom_ = std::max(bottom_, y + 1);
    }
  }

  void add(const Bounds& bounds, const PixelMap& map) {
    const PixelPoint a = map.to_pixels({bounds.min_x, bounds.min_y});
    const PixelPoint b = map.to_pixels({bounds.max_x, bounds.max_y});
    left_ = std::min(left_, clamped(std::floor(std::min(a.x, b.x)), width_));
    right_ = std::max(right_, clamped(std::ceil(std::max(a.x, b.x)), width_));
    top_ = std::min(top_, clamped(std::floor(std::min(a.y, b.y)), height_));
    bottom_ = std::max(bottom_, clamped(std::ceil(std::max(a.y, b.y)), height_));
  }

  // Returns the pixels with a margin; one pixel if there are none.
  [[nodiscard]] PixelWindow window() const {
    if (right_ <= left_) return {0, 0, 1, 1};
    const std::int32_t left = std::max(0, left_ - margin_), top = std::max(0, top_ - margin_);
    return {left, top, std::min(width_, right_ + margin_) - left, std::min(height_, bottom_ + margin_) - top};
  }

 private:
  static std::int32_t clamped(double pixel, std::int32_t most) {
    return static_cast<std::int32_t>(std::clamp(pixel, 0.0, static_cast<double>(most)));
  }

  std::int32_t margin_, width_, height_;
  std::int32_t left_ = width_, top_ = height_, right_ = 0, bottom_ = 0;
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
  PrintMasks masks(engine, display, mask_budget);
  GrowingWindow grown(display, light.pixel.reach() + 1);  // one more, so that walls have an outside
  for (const PlateModel& model : engine.models())
    for (const PixelMap& map : model.copies)
      grown.add(model.model->bounds(), map);
  for (const LayerDose& layer : light.layers)
    if (const Mask* mask = masks.of(layer)) grown.add(*mask);
  const PixelWindow window = grown.window();
  const std::vector<PlateModel> support_models = as_models(supports, display);
  CureComparison comparison(engine.models(), support_models, display, window, light.layers);
  CuredLayers cured(light.cure, window.pixels());
  LightSpread spread(light.pixel, static_cast<std::size_t>(window.columns),
                     static_cast<std::size_t>(window.rows));
  std::vector<float> share(window.pixels());
  CuredPart part;
  for (std::size_t layer = light.layers.size(); layer-- > 0;) {
    if (const Mask* mask = masks.of(light.layers[layer])) {
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
