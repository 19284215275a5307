// Finds out if two models on the plate would be exposed in the same place. Compares their masks layer by
// layer, since bounding boxes are too coarse (a ring around a pin is fine). Thread-safe (no shared state).
#pragma once

#include <optional>

#include "core/mask/pixel_map.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

struct PlacedModel : StandingModel {
  Point center;  // middle of its bounds, from the plate's centre, in millimetres
};

struct Collision {
  Nanometers height;  // height of the lowest layer in which the models meet
  Point place;        // a pixel that both light there, from the plate's centre, in millimetres
};

// True if the bounds overlap as seen from above: if they do not, there is no collision.
[[nodiscard]] bool bounds_overlap(const PlacedModel& a, const PlacedModel& b);

// Returns the lowest layer, cut at its middle, in which both models light the same pixel, even partly;
// nullopt if there is none. Checks only the pixels where the bounds overlap. The display's mirrors do not
// matter. REQUIRES: layer > 0.
[[nodiscard]] std::optional<Collision> find_collision(const PlacedModel& a, const PlacedModel& b,
                                                      const DisplayGeometry& display, Nanometers layer);

}  // namespace contourd
