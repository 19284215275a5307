#include "core/layers/print_layers.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

PrintLayers::PrintLayers(std::vector<StandingModel> models, const AdaptiveLayers& adaptive)
    : models_(std::move(models)), adaptive_(adaptive) {
  expects(adaptive.are_printable(),
          "1 um <= thinnest <= thickest <= kThickestLayer, and the cusp is positive");
  expects(std::ranges::all_of(models_, [](const StandingModel& model) { return model.model != nullptr; }),
          "no model is null");
  for (const StandingModel& model : models_)
    top_ = std::max(top_, model.top());
}

std::optional<Nanometers> PrintLayers::thickness_at(Nanometers bottom) const {
  if (models_.empty()) {
    const bool printed = uniform_.count == 0 || bottom / uniform_.thickness >= uniform_.count;
    return printed ? std::nullopt : std::optional(uniform_.thickness);
  }
  Nanometers thickness = next_thickness(models_.front(), bottom, adaptive_);
  for (const StandingModel& model : models_)
    thickness = std::min(thickness, next_thickness(model, bottom, adaptive_));
  // Above the models, the mask would be dark.
  return is_below_top(bottom + thickness / 2, top_) ? std::optional(thickness) : std::nullopt;
}

std::vector<Nanometers> PrintLayers::all() const {
  // If even the thickest layers are too many, they need not be counted. Rounding to whole steps adds less
  // than one step.
  const Millimeters thickest = to_millimeters(adaptive_.thickest + kLayerStep);
  if (!models_.empty() && !(top_ / thickest <= kMaxLayers)) throw TooManyLayers();
  std::vector<Nanometers> thicknesses;
  Nanometers bottom{};
  while (const std::optional<Nanometers> thickness = thickness_at(bottom)) {
    if (thicknesses.size() == kMaxLayers) throw TooManyLayers();
    thicknesses.push_back(*thickness);
    bottom += *thickness;
  }
  return thicknesses;
}

}  // namespace contourd
