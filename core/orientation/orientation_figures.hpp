// Figures that say how well a model prints with a given direction up, as far as its facets show. Values;
// thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Each weight is for a figure that is as bad as the worst of all directions tried; 0: the figure does not
// count.
struct OrientationWeights {
  double support = 1;     // volume of the supports
  double contacts = 4;    // places where supports meet the model
  double peel = 0.75;     // the largest area that is peeled off at once
  double height = 0.5;    // height of the print, which sets its time
  double standing = 0.5;  // penalty for a model that does not stand on a face of its own
  double keep_clean = 8;  // surfaces to be kept clean that are touched all the same
  bool operator==(const OrientationWeights&) const = default;
};

enum class OrientationPreset : std::uint8_t {
  Auto,   // the resin's weights
  Fast,   // low, with few layers
  Clean,  // few contacts
  Safe,   // little peel force, standing by itself
};
// Returns "auto", "fast", "clean" or "safe".
[[nodiscard]] std::string_view name_of(OrientationPreset preset);
// Returns the preset of this name; nullopt for any other word.
[[nodiscard]] std::optional<OrientationPreset> orientation_preset(std::string_view word);
// Returns the weights of a preset; `own` are the resin's weights.
[[nodiscard]] OrientationWeights weights_of(OrientationPreset preset, const OrientationWeights& own);

// A box in the model's own coordinates.
struct KeepCleanBox {
  Direction least{0, 0, 0}, most{0, 0, 0};  // opposite corners, inclusive
  bool operator==(const KeepCleanBox&) const = default;
};
// A part of the model's surface to keep free of supports and of the plate: the facets that face within 45
// degrees of a direction, or the facets in a box. In the model's own coordinates.
using KeepClean = std::variant<Direction, KeepCleanBox>;

// The size of the machine's build volume.
struct BuildSize {
  Millimeters width, depth, height;
  bool operator==(const BuildSize&) const = default;
};

struct OrientationRequest {
  Scale scale{};                     // as printed, along the plate's axes
  std::optional<BuildSize> build{};  // nullopt: the model fits whichever way it is turned
  SupportSettings supports{};        // with a lift of 0, no model is lifted
  bool keep_own_supports = true;     // a model that carries supports in its file stays as drawn
  std::vector<KeepClean> keep_clean{};
  OrientationWeights weights{};
};

struct OrientationFigures {
  Direction up;             // unit vector
  double score = 0;         // lower is better
  double contacts = 0;      // number of contacts with supports; approximate unless `tried`
  double support_mm3 = 0;   // approximate volume of the supports
  double overhang_mm2 = 0;  // overhangs beyond 45 degrees that need support, seen from above
  double largest_mm2 = 0;   // the largest layer, or of the sections that were calculated
  double standing_mm2 = 0;  // faces that lie flat on the plate
  double touched_mm2 = 0;   // surfaces to be kept clean that supports or the plate touch
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;
  bool stands = false;  // faces flat on the plate hold the model
  bool fits = true;
  bool tried = false;  // contacts, largest_mm2 and stands were found in the layers, not estimated
  bool operator==(const OrientationFigures&) const = default;
};

}  // namespace contourd
