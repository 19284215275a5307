// A model and how high it stands. A value; thread-safe as any value is.
#pragma once

#include <memory>

#include "core/model/elevation.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

struct StandingModel {
  std::shared_ptr<const HeightIndex> model;  // never null
  Elevation elevation{};

  // Where the plane at a height above the plate cuts the model.
  [[nodiscard]] Millimeters z_at(Nanometers height) const { return elevation.z_at(height, model->bounds()); }
  // Of its highest point, above the plate.
  [[nodiscard]] Millimeters top() const { return elevation.top(model->bounds()); }
};

}  // namespace contourd
