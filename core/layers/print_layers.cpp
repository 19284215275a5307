#include "core/layers/print_layers.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

PrintLayers::PrintLayers(std::vector<std::shared_ptr<const HeightIndex>> models,
                         const AdaptiveLayers& adaptive)
    : models_(std::move(models)), adaptive_(adaptive) {
  for (const auto& model : models_)
    height_mm_ = std::max(height_mm_, model->bounds().size_z());
}

std::optional<Nanometers> PrintLayers::thickness_at(Nanometers bottom) const {
  if (models_.empty()) {
    const bool printed = uniform_.count == 0 || bottom / uniform_.thickness >= uniform_.count;
    return printed ? std::nullopt : std::optional(uniform_.thickness);
  }
  // A rest of half a layer's step is the rounding of heights.
  const double rest_mm = height_mm_ - to_millimeters(bottom).count();
  if (!(rest_mm > to_millimeters(kLayerStep).count() / 2)) return std::nullopt;
  Nanometers thickness = next_thickness(*models_.front(), bottom, adaptive_);
  for (const auto& model : models_)
    thickness = std::min(thickness, next_thickness(*model, bottom, adaptive_));
  return thickness;
}

std::vector<Nanometers> PrintLayers::all() const {
  // Where even the thickest are too many, they need not be counted. Rounding to whole steps adds less than
  // one.
  const double thickest_mm = to_millimeters(adaptive_.thickest + kLayerStep).count();
  if (!models_.empty() && !(height_mm_ / thickest_mm <= kMostLayers)) throw TooManyLayers();
  std::vector<Nanometers> thicknesses;
  Nanometers bottom{};
  while (const std::optional<Nanometers> thickness = thickness_at(bottom)) {
    if (thicknesses.size() == kMostLayers) throw TooManyLayers();
    thicknesses.push_back(*thickness);
    bottom += *thickness;
  }
  return thicknesses;
}

}  // namespace contourd
