// Models that need supports, and the contacts that a sweep finds for them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/overhangs/overhang_sweep.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// An observer that only records the sweep's grid and the layers' heights.
class CountingObserver final : public LayerObserver {
 public:
  void begin(const DisplayGeometry& sweep_display, Nanometers sweep_step) override {
    display = sweep_display;
    step = sweep_step;
  }
  void layer(Nanometers height, const MaskRuns&) override { heights.push_back(height); }

  DisplayGeometry display;
  Nanometers step;
  std::vector<Nanometers> heights;
};

// A build area of 40 by 40 mm.
inline const DisplayGeometry kHeldDisplay{Pixels{800}, Pixels{800}, Micrometers{50.0}};

// Returns a request with the model's (0, 0) on the plate's centre and its lowest point `lift_mm` above the
// plate.
inline SupportRequest held_request(const models::Facets& facets, double lift_mm,
                                   const SupportSettings& settings = {}) {
  const auto lift = to_nanometers(Millimeters{lift_mm}).value();
  const StandingModel standing{std::make_shared<const HeightIndex>(facets), Elevation{lift}};
  return {{PlateModel{standing, {PixelMap::true_scale(kHeldDisplay, {0, 0})}}}, kHeldDisplay, settings};
}

inline std::vector<SupportContact> contacts_of(const SupportRequest& request) {
  CountingObserver observer;
  return find_overhangs(request, observer).value().contacts;
}
inline std::vector<SupportContact> contacts_of(const models::Facets& facets, double lift_mm,
                                               const SupportSettings& settings = {}) {
  return contacts_of(held_request(facets, lift_mm, settings));
}

// Returns a prism from y = -depth / 2 to depth / 2. Its outline in x and z is convex and counter-clockwise
// with x pointing right and z up.
inline models::Facets prism(std::span<const Point> outline, double depth) {
  models::Facets facets;
  const auto at = [&](std::size_t i, double side) {
    const Point& p = outline[i % outline.size()];
    return Vertex{static_cast<float>(p.x), static_cast<float>(side * depth / 2), static_cast<float>(p.y)};
  };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    facets.push_back({{at(i, -1), at(i + 1, -1), at(i + 1, 1)}});
    facets.push_back({{at(i, -1), at(i + 1, 1), at(i, 1)}});
    if (i + 2 >= outline.size()) continue;
    facets.push_back({{at(0, -1), at(i + 1, -1), at(i + 2, -1)}});
    facets.push_back({{at(0, 1), at(i + 2, 1), at(i + 1, 1)}});
  }
  return facets;
}

}  // namespace contourd::testing
