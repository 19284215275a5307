// A model and its height above the plate. A value; thread-safe as any value is.
#pragma once

#include <memory>
#include <optional>

#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

// The height of a model above the plate: converts between heights above the plate and the model's own z.
// Parameters called `model` are the bounds of the model's facets.
class Elevation {
 public:
  // Places the model's lowest point on the plate.
  constexpr Elevation() = default;
  // Places the model's lowest point at a height above the plate.
  constexpr explicit Elevation(Nanometers above_plate) : above_plate_(above_plate) {}

  [[nodiscard]] constexpr Nanometers above_plate() const { return above_plate_; }

  // Returns the model's z at a height above the plate.
  [[nodiscard]] Millimeters z_at(Nanometers height, const Bounds& model) const {
    return Millimeters{model.min_z} + to_millimeters(height - above_plate_);
  }
  // Returns the height above the plate of a model's z; nullopt if it is beyond what a height can be.
  [[nodiscard]] std::optional<Nanometers> height_at(Millimeters z, const Bounds& model) const {
    const std::optional<Nanometers> above_lowest = to_nanometers(z - Millimeters{model.min_z});
    if (!above_lowest) return std::nullopt;
    return *above_lowest + above_plate_;
  }
  // Returns how far the model is moved up from its own z to stand there.
  [[nodiscard]] Millimeters lift(const Bounds& model) const {
    return to_millimeters(above_plate_) - Millimeters{model.min_z};
  }
  // Returns the height of the model's highest point above the plate.
  [[nodiscard]] Millimeters top(const Bounds& model) const {
    return to_millimeters(above_plate_) + Millimeters{model.size_z()};
  }

  bool operator==(const Elevation&) const = default;

 private:
  Nanometers above_plate_{};
};

struct StandingModel {
  std::shared_ptr<const HeightIndex> model;  // never null
  Elevation elevation{};

  // Returns the model's z at a height above the plate.
  [[nodiscard]] Millimeters z_at(Nanometers height) const { return elevation.z_at(height, model->bounds()); }
  // Returns the height above the plate from which on all sections are empty: that of the highest point, less
  // the unevenness of a flat face there.
  [[nodiscard]] Millimeters top() const {
    Bounds bounds = model->bounds();
    bounds.max_z = model->end_z();
    return elevation.top(bounds);
  }
};

}  // namespace contourd
