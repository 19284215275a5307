// Weights for choosing which way up a model prints best. Values; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

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

}  // namespace contourd
