#include "core/cure/layer_bonds.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Light from this share on counts as full: what remains is the rounding of sums.
constexpr float kFullLight = 0.999F;

}  // namespace

LayerBonds::LayerBonds(const CureSettings& settings, std::span<const LayerDose> layers, std::size_t width)
    : layers_(layers),
      width_(width),
      depth_mm_(to_millimeters(settings.curve.penetration_depth).count()),
      critical_(settings.curve.critical_dose.count()),
      dead_zone_mm_(to_millimeters(settings.dead_zone).count()) {
  expects(width >= 1, "a layer has pixels");
}

void LayerBonds::add_layer(std::size_t number, const Light& light) {
  expects(number < layers_.size() && light.covered.size() == light.share.size() &&
              light.dose.size() == light.share.size() && light.share.size() % width_ == 0,
          "the layer is one of the print's, with light for each pixel of whole rows");
  if (number + 1 < layers_.size() && layers_[number].peeled) compare(number + 1, light);
  gather(number, light);
}

// Returns the dose at the layer's top of its own light and of that above it until the next peel.
double LayerBonds::own_dose(std::size_t number, const Light& light, std::size_t pixel) const {
  const double above = above_.empty() ? 0 : static_cast<double>(above_[pixel]);
  return static_cast<double>(light.share[pixel]) * layers_[number].dose.count() / critical_ + above;
}

LayerBonds::Dimmed LayerBonds::dimmed(std::size_t number, const Light& light, std::size_t pixel) const {
  Dimmed found{pixel, 0, 0};
  const std::size_t column = pixel % width_, row = pixel / width_, rows = light.share.size() / width_;
  for (std::size_t y = row - std::min<std::size_t>(row, 1); y <= std::min(row + 1, rows - 1); ++y) {
    for (std::size_t x = column - std::min<std::size_t>(column, 1); x <= std::min(column + 1, width_ - 1);
         ++x) {
      const std::size_t each = y * width_ + x;
      if (light.covered[each] != 255) continue;
      found.own = std::max(found.own, static_cast<float>(own_dose(number, light, each)));
      found.dose = std::max(found.dose, light.dose[each]);
    }
  }
  return found;
}

void LayerBonds::compare(std::size_t upper, const Light& lower) {
  const double thickness_mm = in_mm(layers_[upper].thickness);
  const double to_lower_side = std::exp(-(thickness_mm + dead_zone_mm_) / depth_mm_);
  const double of_greatest = std::exp(-thickness_mm / depth_mm_);
  const double lower_dose =
      layers_[upper - 1].dose.count() / critical_ * std::exp(-dead_zone_mm_ / depth_mm_);
  for (const Dimmed& each : dimmed_) {
    if (lower.covered[each.pixel] != 255 || lower.dose[each.pixel] < 1) continue;
    const bool was_solid = lower_dose * static_cast<double>(lower.share[each.pixel]) >= 1;
    const double own = static_cast<double>(each.own);
    const bool is_bonded_alone = was_solid && own * std::exp(-dead_zone_mm_ / depth_mm_) >= 1;
    const double bond = is_bonded_alone ? own * to_lower_side : static_cast<double>(each.dose) * of_greatest;
    if (!weakest_ || bond < weakest_->dose) weakest_ = {bond, upper, each.pixel};
  }
}

void LayerBonds::gather(std::size_t number, const Light& light) {
  const LayerDose& layer = layers_[number];
  if (layer.peeled) above_.clear();
  dimmed_.clear();
  constexpr std::size_t kBlock = 64;
  for (std::size_t first = 0; first < light.share.size(); first += kBlock) {
    const std::size_t end = std::min(first + kBlock, light.share.size());
    unsigned any = 0;
    for (std::size_t pixel = first; pixel < end; ++pixel)
      any |= static_cast<unsigned>(light.covered[pixel] == 255) &
             static_cast<unsigned>(light.share[pixel] < kFullLight);
    if (any == 0) continue;
    for (std::size_t pixel = first; pixel < end; ++pixel)
      if (light.covered[pixel] == 255 && light.share[pixel] < kFullLight && light.dose[pixel] >= 1)
        dimmed_.push_back(dimmed(number, light, pixel));
  }
  if (number == 0 || layers_[number - 1].peeled) return;
  const double falloff = std::exp(-in_mm(layer.top - layers_[number - 1].top) / depth_mm_);
  std::vector<float> above(light.share.size());
  for (std::size_t pixel = 0; pixel < above.size(); ++pixel)
    above[pixel] = static_cast<float>(own_dose(number, light, pixel) * falloff);
  above_ = std::move(above);
}

}  // namespace contourd
