// How a model prints with one of its directions up, as far as its facets tell. Values; thread-safe.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_weights.hpp"

namespace contourd {

// What to keep free of supports and of the plate, in the model's own coordinates: what looks within 45
// degrees of a direction, or what lies in a box.
struct KeepCleanBox {
  Direction least{0, 0, 0}, most{0, 0, 0};  // both corners belong to it
  bool operator==(const KeepCleanBox&) const = default;
};
using KeepClean = std::variant<Direction, KeepCleanBox>;

// Of what the machine can print.
struct BuildSize {
  Millimeters width, depth, height;
  bool operator==(const BuildSize&) const = default;
};

struct OrientationRequest {
  Scale scale{};                     // as it is printed, along the plate's axes
  std::optional<BuildSize> build{};  // nothing: whatever it is turned to, it fits
  Millimeters lift{};                // how high it is held that does not stand by itself
  Millimeters bridge{1.5};           // how far a layer reaches out beyond what carries it
  std::vector<KeepClean> keep_clean{};
  OrientationWeights weights{};
};

struct OrientationFigures {
  Direction up;             // of length 1
  double score = 0;         // less is better
  double contacts = 0;      // where it is to be held, about
  double support_mm3 = 0;   // of pillars to there, about
  double overhang_mm2 = 0;  // of what hangs over beyond 45 degrees and is to be held, seen from above
  double largest_mm2 = 0;   // the largest section, of so many heights
  double standing_mm2 = 0;  // of faces that lie flat on the plate
  double touched_mm2 = 0;   // of what is to be kept free
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;
  bool stands = false;  // such a face holds it
  bool fits = true;
  bool operator==(const OrientationFigures&) const = default;
};

}  // namespace contourd
