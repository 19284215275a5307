// How high a model stands above the plate: the one place that converts between heights above the plate and a
// model's own z. A value; thread-safe as any value is.
#pragma once

#include <optional>

#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// `model` is the bounds of its facets.
class Elevation {
 public:
  // Its lowest point lies on the plate.
  constexpr Elevation() = default;
  // Its lowest point lies that high above the plate.
  constexpr explicit Elevation(Nanometers above_plate) : above_plate_(above_plate) {}

  [[nodiscard]] constexpr Nanometers above_plate() const { return above_plate_; }

  // Where the plane at a height above the plate cuts the model.
  [[nodiscard]] Millimeters z_at(Nanometers height, const Bounds& model) const {
    return Millimeters{model.min_z} + to_millimeters(height - above_plate_);
  }
  // The other way; nothing beyond what a height can be.
  [[nodiscard]] std::optional<Nanometers> height_at(Millimeters z, const Bounds& model) const {
    const std::optional<Nanometers> above_lowest = to_nanometers(z - Millimeters{model.min_z});
    if (!above_lowest) return std::nullopt;
    return *above_lowest + above_plate_;
  }
  // How far the model is moved up from its own z to stand there.
  [[nodiscard]] Millimeters lift(const Bounds& model) const {
    return to_millimeters(above_plate_) - Millimeters{model.min_z};
  }
  // The height of its highest point, above the plate.
  [[nodiscard]] Millimeters top(const Bounds& model) const {
    return to_millimeters(above_plate_) + Millimeters{model.size_z()};
  }

  bool operator==(const Elevation&) const = default;

 private:
  Nanometers above_plate_{};
};

}  // namespace contourd
