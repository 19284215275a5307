// What counts how much when it is chosen which way up a model prints. Values; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace contourd {

// Each is for a figure that is as bad as the worst of all directions tried; 0: it does not count.
struct OrientationWeights {
  double support = 1;     // volume of the supports
  double contacts = 4;    // places where supports meet the model
  double peel = 0.75;     // the largest area that is peeled off at once
  double height = 0.5;    // and so the time
  double standing = 0.5;  // where it does not stand on a face of its own
  double keep_clean = 8;  // surfaces to be kept free that are touched all the same
  bool operator==(const OrientationWeights&) const = default;
};

enum class OrientationPreset : std::uint8_t {
  Auto,   // by the resin's weights
  Fast,   // low: few layers
  Clean,  // few contacts
  Safe,   // little peel, standing by itself
};
// "auto", "fast", "clean", "safe".
[[nodiscard]] std::string_view name_of(OrientationPreset preset);
// Nothing for another word.
[[nodiscard]] std::optional<OrientationPreset> orientation_preset(std::string_view word);
// `own` are the resin's.
[[nodiscard]] OrientationWeights weights_of(OrientationPreset preset, const OrientationWeights& own);

}  // namespace contourd
