#include "core/cure/cured_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Light that adds less than this to the dose, in units of Ec, is forgotten: all of it together moves an
// underside by less than a 1000th of Dp.
constexpr double kFaintest = 1e-4;
// Liquid that is thinner than this at a layer's bottom is a rounding error of the dose, a float.
constexpr Millimeters kThinnestLiquid{1e-6};
constexpr double kAllLight = std::numeric_limits<std::uint16_t>::max();
constexpr auto kMostUnlit = std::numeric_limits<std::uint16_t>::max();

}  // namespace

CuredLayers::CuredLayers(const CureSettings& settings, std::size_t pixels)
    : settings_(settings),
      depth_mm_(to_millimeters(settings.curve.penetration_depth).count()),
      kept_(settings.peel_memory),
      lost_(settings.oxygen_dose / settings.curve.critical_dose),
      dose_(pixels),
      unlit_(pixels, kMostUnlit) {
  expects(depth_mm_ > 0 && settings.curve.critical_dose.count() > 0, "the working curve has positive values");
  expects(kept_ >= 0 && kept_ <= 1 && lost_ >= 0 && settings.dead_zone.count() >= 0,
          "the memory is a share, and the losses are not negative");
  if (kept_ < 1 && lost_ == 0) in_the_dark_.resize(pixels);
}

std::span<const float> CuredLayers::add_layer(const LayerDose& layer, std::span<const float> light) {
  expects(light.size() == dose_.size(), "each pixel has a share of the light");
  expects(last_top_ == Nanometers{} || layer.top <= last_top_, "layers are added from the top down");
  const double dead_zone_mm = to_millimeters(settings_.dead_zone).count();
  const double dose = layer.dose / settings_.curve.critical_dose * std::exp(-dead_zone_mm / depth_mm_);
  if (kept_ == 1 && lost_ == 0) {
    sum_doses(layer, dose, light);
  } else {
    remember(layer, dose, light);
    follow_doses(layer, dose, light);
  }
  last_top_ = layer.top;
  return dose_;
}

// Adds the layer's light to that of all layers above it.
void CuredLayers::sum_doses(const LayerDose& layer, double dose, std::span<const float> light) {
  const bool is_first = last_top_ == Nanometers{};
  const auto falloff =
      is_first ? 0.0F : static_cast<float>(std::exp(-in_mm(last_top_ - layer.top) / depth_mm_));
  const auto full = static_cast<float>(dose);
  for (std::size_t pixel = 0; pixel < dose_.size(); ++pixel)
    dose_[pixel] = dose_[pixel] * falloff + full * light[pixel];
}

// Finds the doses of resin that loses a part at each peel. Most pixels need no look at the layers above:
// their own layer solidifies them, or nothing above lights them.
void CuredLayers::follow_doses(const LayerDose& layer, double dose, std::span<const float> light) {
  const double thickness_mm = in_mm(layer.thickness), all_solid = std::exp(thickness_mm / depth_mm_);
  const auto most = static_cast<std::uint16_t>(std::min<std::size_t>(layers_.size(), kMostUnlit));
  constexpr std::size_t kBlock = 64;
  std::array<std::uint8_t, kBlock> follows{};
  for (std::size_t first = 0; first < dose_.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, dose_.size() - first);
    std::uint8_t any = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double own = dose * static_cast<double>(light[first + i]);
      dose_[first + i] = static_cast<float>(own);
      follows[i] = static_cast<std::uint8_t>(static_cast<unsigned>(own < all_solid) &
                                             static_cast<unsigned>(unlit_[first + i] < most));
      any |= follows[i];
    }
    if (any == 0) continue;
    for (std::size_t i = 0; i < count; ++i) {
      if (follows[i] == 0) continue;
      const std::size_t pixel = first + i;
      dose_[pixel] =
          static_cast<float>(lost_ == 0 ? dose_in_the_dark(pixel) : greatest_solid(pixel, thickness_mm));
    }
  }
}

void CuredLayers::remember(const LayerDose& layer, double dose, std::span<const float> light) {
  if (!layer.peeled && !layers_.empty()) return add_to_last(layer, dose, light);
  while (!layers_.empty() &&
         layers_.back().dose * std::exp(-in_mm(layers_.back().top - layer.top) / depth_mm_) < kFaintest) {
    spare_ = std::move(layers_.back().light);
    layers_.pop_back();
  }
  LitLayer lit{layer.top, dose, std::move(spare_)};
  lit.light.resize(light.size());
  std::uint16_t* const of_layer = lit.light.data();
  std::uint16_t* const unlit = unlit_.data();
  for (std::size_t pixel = 0; pixel < light.size(); ++pixel) {
    const auto share = static_cast<std::uint16_t>(
        static_cast<std::int32_t>(light[pixel] * static_cast<float>(kAllLight) + 0.5F));
    of_layer[pixel] = share;
    const auto next = static_cast<std::uint16_t>(unlit[pixel] + (unlit[pixel] < kMostUnlit ? 1 : 0));
    unlit[pixel] = share > 0 ? std::uint16_t{0} : next;
  }
  layers_.push_front(std::move(lit));
  ++pushed_;
  reach(layer.top);
}

// Adds the layer's light to that of the last ones, from which no peel separates it.
void CuredLayers::add_to_last(const LayerDose& layer, double dose, std::span<const float> light) {
  LitLayer& last = layers_.front();
  const double above = last.dose * std::exp(-in_mm(last.top - layer.top) / depth_mm_);
  const double sum = above + dose;
  const auto of_above = static_cast<float>(sum > 0 ? above / sum : 0);
  const auto of_layer = static_cast<float>(sum > 0 ? dose / sum * kAllLight : 0);
  for (std::size_t pixel = 0; pixel < light.size(); ++pixel) {
    std::uint16_t& both = last.light[pixel];
    both = static_cast<std::uint16_t>(static_cast<float>(both) * of_above + light[pixel] * of_layer + 0.5F);
    if (both > 0) unlit_[pixel] = 0;
  }
  last.top = layer.top;
  last.dose = sum;
  // The light of the last layers was rounded again.
  std::ranges::fill(in_the_dark_, DarkDose{});
  reach(layer.top);
}

// Finds how much light of each layer reaches this height.
void CuredLayers::reach(Nanometers top) {
  reaching_.clear();
  for (const LitLayer& above : layers_)
    reaching_.push_back(above.dose / kAllLight * std::exp(-in_mm(above.top - top) / depth_mm_));
  most_above_.assign(layers_.size(), 0);
  for (std::size_t above = layers_.size(); above-- > 1;)
    most_above_[above - 1] = std::max(kAllLight * reaching_[above], most_above_[above]);
}

// Returns the greatest dose that a pixel's resin below the last layer's top ever had, in units of Ec.
CuredLayers::Greatest CuredLayers::greatest_dose(std::size_t pixel, double below_top_mm) const {
  const double falloff = below_top_mm == 0 ? 1 : std::exp(-below_top_mm / depth_mm_);
  double dose = 0;
  Greatest greatest;
  for (std::size_t layer = unlit_[pixel]; layer < layers_.size(); ++layer) {
    dose = std::max(dose * kept_ - lost_, 0.0) + reaching_[layer] * layers_[layer].light[pixel] * falloff;
    if (dose > greatest.dose) greatest = {dose, layer};
    // No layer above can add what is lost of such a dose.
    if (greatest.dose * kept_ + most_above_[layer] * falloff <= greatest.dose) break;
  }
  return greatest;
}

// Returns the greatest dose that a pixel's resin at the last layer's top ever had, where losses are shares.
// Below the last layer that lit the pixel, all doses fall by the same factor: the greatest one stays the
// greatest, and need not be searched again.
double CuredLayers::dose_in_the_dark(std::size_t pixel) {
  DarkDose& dark = in_the_dark_[pixel];
  if (unlit_[pixel] > 1 && dark.layer > 0 && pushed_ - dark.layer < layers_.size())
    return dark.share * reaching_[pushed_ - dark.layer];
  const Greatest greatest = greatest_dose(pixel, 0);
  const double reaching = reaching_[greatest.layer];
  dark = greatest.dose > 0 && reaching > 0 ? DarkDose{greatest.dose / reaching, pushed_ - greatest.layer}
                                           : DarkDose{};
  return greatest.dose;
}

// Returns the dose at the layer's top that stands for the solid's thickness. A loss that is subtracted is the
// same at all heights, so that the dose is no multiple of one figure, and the solid's end is searched.
double CuredLayers::greatest_solid(std::size_t pixel, double thickness_mm) const {
  const double at_top = greatest_dose(pixel, 0).dose;
  if (at_top < 1 || greatest_dose(pixel, thickness_mm).dose >= 1) return at_top;
  double solid = 0, liquid = thickness_mm;
  constexpr int kHalvings = 16;  // to a 65536th of the layer
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = (solid + liquid) / 2;
    (greatest_dose(pixel, middle).dose >= 1 ? solid : liquid) = middle;
  }
  return std::exp(solid / depth_mm_);
}

Millimeters CuredLayers::solid_top(const LayerDose& layer) const {
  return to_millimeters(layer.top) - to_millimeters(settings_.dead_zone);
}

Millimeters CuredLayers::solid_thickness(const LayerDose& layer, float dose) const {
  if (dose < 1) return Millimeters{};
  const Millimeters solid{depth_mm_ * std::log(static_cast<double>(dose))};
  const Millimeters whole = to_millimeters(layer.thickness);
  return whole - solid <= kThinnestLiquid ? whole : solid;
}

double CuredLayers::dose_at_top(Millimeters depth) const {
  return std::exp(depth.count() / depth_mm_);
}

}  // namespace contourd
