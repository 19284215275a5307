// Whether two models on the plate would be exposed in the same place: by their masks, layer after layer,
// since what their bounding boxes say is too coarse (a ring around a pin is fine). Thread-safe (no shared
// state).
#pragma once

#include <optional>

#include "core/mask/pixel_map.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

struct PlacedModel : StandingModel {
  Point center;  // of its bounds, from the plate's centre, in millimetres
};

struct Collision {
  Nanometers height;  // of the lowest layer in which they meet
  Point place;        // of a pixel that both light there, from the plate's centre, in millimetres
};

// Whether the bounds overlap, seen from above: without that, there is no collision.
[[nodiscard]] bool bounds_overlap(const PlacedModel& a, const PlacedModel& b);

// The lowest layer, of those cut at their middles, in which both light the same pixel, if only in part. Only
// the pixels of the bounds' overlap are looked at. The display's mirrors do not matter. REQUIRES: layer > 0.
[[nodiscard]] std::optional<Collision> find_collision(const PlacedModel& a, const PlacedModel& b,
                                                      const DisplayGeometry& display, Nanometers layer);

}  // namespace contourd
