// Finds the models' surface near a place that a sweep found: its exact height, and which way it looks. Not
// thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

class SurfaceProbe {
 public:
  // The models must outlive it. `display` is what their copies map to.
  SurfaceProbe(std::span<const PlateModel> models, const DisplayGeometry& display);

  struct Range {
    double low_mm, high_mm;  // above the plate
  };
  struct Surface {
    double z_mm;  // above the plate
    Direction outward;
  };
  // The undermost surface over or beside a point of the plate that looks down, within a range of heights and
  // `reach_mm` of the point; right over it where there is one. Nothing where there is none.
  [[nodiscard]] std::optional<Surface> beneath(Point place, const Range& range, double reach_mm) const;

 private:
  struct PlacedFacet {
    PlatePoint a, b, c;
  };
  template <typename Visit>
  void for_each_facet(const PlatePoint& low, const PlatePoint& high, Visit&& visit) const;

  std::span<const PlateModel> models_;
  DisplayGeometry display_;
};

}  // namespace contourd
