#include "core/cure/cured_part.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/cure/layer_bonds.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {
namespace {

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
      if (y < top_ + margin || y >= bottom_ - margin) {
        if (is_dark(row)) continue;
      } else {
        // Pixels between these cannot make the window grow.
        const auto left = static_cast<std::size_t>(std::min(width_, left_ + margin));
        const auto right = static_cast<std::size_t>(std::max(0, right_ - margin));
        if (is_dark(row.first(left)) && is_dark(row.subspan(right))) continue;
      }
      const auto is_lit = [](std::uint8_t grey) { return grey > 0; };
      const auto first = std::ranges::find_if(row, is_lit);
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
  static bool is_dark(std::span<const std::uint8_t> pixels) {
    unsigned any = 0;
    for (const std::uint8_t grey : pixels)
      any |= grey;
    return any == 0;
  }

  std::int32_t width_, height_, left_, top_, right_, bottom_;
};

void read_coverage(const Mask& coverage, const PixelWindow& window, std::span<std::uint8_t> covered) {
  auto to = covered.begin();
  for (std::int32_t y = window.row; y < window.row + window.rows; ++y)
    to = std::ranges::copy(coverage.row(y).subspan(static_cast<std::size_t>(window.column),
                                                   static_cast<std::size_t>(window.columns)),
                           to)
             .out;
}

void read_light(const Mask& mask, const PixelWindow& window, std::span<float> light) {
  const auto columns = static_cast<std::size_t>(window.columns);
  float* to = light.data();
  for (std::int32_t y = window.row; y < window.row + window.rows; ++y, to += columns) {
    const std::uint8_t* const row = mask.row(y).data() + window.column;
    for (std::size_t x = 0; x < columns; ++x)
      to[x] = static_cast<float>(row[x]) / 255.0F;
  }
}

bool is_stopped(const PrintLight& light) {
  return light.is_stopped && light.is_stopped();
}

void find_weakest_bond(const PrintLight& light, const std::optional<LayerBond>& dimmed, CuredPart& part) {
  const double depth_mm = to_millimeters(light.cure.curve.penetration_depth).count();
  const double dead_zone_mm = to_millimeters(light.cure.dead_zone).count();
  double above = 0;  // dose of the layers above, at this layer's top, since the next peel
  for (std::size_t layer = light.layers.size(); layer-- > 1;) {
    const LayerDose& of = light.layers[layer];
    const double at_top = of.dose / light.cure.curve.critical_dose + (of.peeled ? 0 : above);
    above = at_top * std::exp(-in_mm(of.top - light.layers[layer - 1].top) / depth_mm);
    if (!light.layers[layer - 1].peeled) continue;
    const double bond = at_top * std::exp(-(in_mm(of.thickness) + dead_zone_mm) / depth_mm);
    if (part.weakest_bond_layer > 0 && bond > part.weakest_bond) continue;
    part.weakest_bond = bond;
    part.weakest_bond_layer = static_cast<std::int32_t>(layer);
  }
  if (!dimmed || dimmed->dose >= part.weakest_bond) return;
  part.weakest_bond = dimmed->dose;
  part.weakest_bond_layer = static_cast<std::int32_t>(dimmed->layer);
}

}  // namespace

PrintMasks::PrintMasks(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
                       std::optional<std::chrono::nanoseconds> budget)
    : engine_(engine),
      given_(light.given),
      layers_(light.cuts()),
      dimmed_(light.undersides != nullptr ? light.layers.size() : 0),
      threshold_({.threshold = engine.threshold()}, std::nullopt),
      changed_(display.width, display.height),
      budget_(budget) {
  expects(light.mask_heights.empty() || light.mask_heights.size() == light.layers.size(),
          "each layer has a height, or none");
  leave_dark(light.dark, layers_, engine, light.undersides);
  for (std::size_t layer = 0; layer < dimmed_.size() && !is_stopped(light); ++layer) {
    const std::span<const DimmedPixel> pixels = light.undersides->dimmed(layer);
    dimmed_[layer].assign(pixels.begin(), pixels.end());
    unfound_ += light.undersides->are_found(layer) ? 0 : 1;
  }
}

const Mask* PrintMasks::of(std::size_t number) {
  MaskBudget budget;
  if (budget_) budget = MaskBudget(MaskBudget::Clock::now() + *budget_);
  if (engine_.mask_within(layers_.height_of(number), budget) == nullptr) return nullptr;
  const Mask& wanted = wanted_of(number);
  return given_ != nullptr ? &given_->of(number, wanted) : &wanted;
}

const Mask& PrintMasks::wanted_of(std::size_t number) {
  if (threshold_.is_none() && dimmed_.empty()) return engine_.coverage();
  threshold_.apply(engine_.coverage(), changed_);
  if (!dimmed_.empty()) dim(dimmed_[number], changed_);
  return changed_;
}

PrintCure::PrintCure(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
                     std::optional<std::chrono::nanoseconds> mask_budget)
    : engine_(engine), display_(display), light_(light), masks_(engine, display, light, mask_budget) {
  const std::int32_t margin = light_.pixel.reach() + 1;  // one more, so that walls have an outside
  GrowingWindow grown(window_of(engine.models(), display, margin), display);
  for (std::size_t layer = 0; layer < light_.layers.size() && !is_stopped(light_); ++layer) {
    const Mask* mask = masks_.of(layer);
    if (mask != nullptr) grown.add(*mask, margin);
    if (light_.mask_heights.empty()) continue;
    const Mask& lit = light_.undersides != nullptr && mask != nullptr ? *mask : engine.coverage();
    lit_pixels_.push_back(mask != nullptr ? lit.lit_area() : 0);
  }
  window_ = grown.window();
}

template <typename Layer>
std::int64_t PrintCure::cure_layers(Layer&& layer) {
  CuredLayers cured(light_.cure, window_.pixels());
  LightSpread spread(light_.pixel, static_cast<std::size_t>(window_.columns),
                     static_cast<std::size_t>(window_.rows));
  std::vector<float> share(window_.pixels());
  std::int64_t abandoned = 0;
  for (std::size_t number = light_.layers.size(); number-- > 0 && !is_stopped(light_);) {
    const Mask* const mask = masks_.of(number);
    if (mask != nullptr) {
      read_light(*mask, window_, share);
    } else {
      std::ranges::fill(share, 0.0F);
      ++abandoned;
    }
    spread.apply(share);
    layer(CuredLayer{number, cured, share, cured.add_layer(light_.layers[number], share), mask != nullptr});
  }
  return abandoned;
}

std::optional<CuredPart> PrintCure::compare(const Supports* supports) {
  if (is_stopped(light_)) return std::nullopt;
  const CutLayers cuts = light_.cuts();
  const std::vector<ComparedModel> models = compared_models(engine_.models(), light_.dark, cuts);
  std::vector<ComparedModel> support_models;
  if (supports != nullptr && supports->structure)
    support_models = compared_supports(*supports->structure, display_, light_.dark, cuts);
  CuredPart part;
  try {
    CureComparison comparison(models, support_models, display_, window_, light_.layers, light_.is_stopped);
    LayerBonds bonds(light_.cure, light_.layers, static_cast<std::size_t>(window_.columns));
    const bool has_dimmed_pixels = masks_.darken() || !light_.pixel.gaussians.empty();
    std::vector<std::uint8_t> covered;
    part.abandoned_layers = cure_layers([&](const CuredLayer& layer) {
      comparison.add_layer(layer.number, layer.cured, layer.dose);
      if (!has_dimmed_pixels) return;
      covered.assign(window_.pixels(), 0);
      if (layer.has_mask) read_coverage(engine_.coverage(), window_, covered);
      bonds.add_layer(layer.number, {covered, layer.share, layer.dose});
    });
    if (is_stopped(light_)) return std::nullopt;
    part.figures = comparison.figures();
    find_weakest_bond(light_, bonds.weakest(), part);
  } catch (const ComputationStopped&) {
    return std::nullopt;
  }
  part.unfound_undersides = masks_.unfound();
  part.cut_copies = cut_copies(engine_.models(), light_.dark, cuts);
  return part;
}

void PrintCure::make_surface(std::int32_t step, std::function<void(const Facet&)> sink) {
  CuredSurface surface(display_, window_, step, std::move(sink));
  cure_layers([&](const CuredLayer& layer) {
    surface.add_layer(light_.layers[layer.number], layer.cured, layer.dose);
  });
  surface.finish();
}

CuredPart cure_part(ContourEngine& engine, const DisplayGeometry& display, const PrintLight& light,
                    const Supports* supports, std::optional<std::chrono::nanoseconds> mask_budget) {
  return PrintCure(engine, display, light, mask_budget).compare(supports).value();
}

}  // namespace contourd
