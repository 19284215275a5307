#include "core/orientation/nearly_level_base.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/model/height_index.hpp"
#include "core/orientation/candidate_directions.hpp"
#include "core/support/support_lift.hpp"

namespace contourd {

std::optional<LevelBase> nearly_level_base(std::span<const Facet> facets, const SupportSettings& settings,
                                           Nanometers layer) {
  expects(layer > Nanometers{}, "a layer has a thickness");
  if (facets.empty()) return std::nullopt;
  SupportSettings lifting = settings;
  lifting.lift = Millimeters{1};  // so that a lift of 0 means that the model stands
  for (const Direction& up : face_directions(facets)) {
    if (up.z < kCosNearlyLevel) continue;
    std::vector<Facet> turned(facets.begin(), facets.end());
    orient(turned, {.up = up});
    if (support_lift(HeightIndex(std::move(turned)), lifting, layer) > Nanometers{}) continue;
    constexpr double kDegrees = 180 / 3.14159265358979323846;
    return LevelBase{up, std::atan2(std::hypot(up.x, up.y), up.z) * kDegrees};
  }
  return std::nullopt;
}

}  // namespace contourd
