// A model and its height above the plate. A value; thread-safe as any value is.
#pragma once

#include <memory>

#include "core/model/elevation.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

struct StandingModel {
  std::shared_ptr<const HeightIndex> model;  // never null
  Elevation elevation{};

  // Returns the model's z at a height above the plate.
  [[nodiscard]] Millimeters z_at(Nanometers height) const { return elevation.z_at(height, model->bounds()); }
  // Returns the height of the model's highest point above the plate.
  [[nodiscard]] Millimeters top() const { return elevation.top(model->bounds()); }
};

}  // namespace contourd
