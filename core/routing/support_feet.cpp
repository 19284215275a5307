#include "core/routing/support_feet.hpp"

#include <algorithm>
#include <array>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Feet are halved in height down to half of this, unless the settings ask for less.
constexpr double kLowest_mm = 0.1;

}  // namespace

Frustum foot_at(const PlatePoint& place, double radius_mm, const ClearanceField& field,
                const SupportSettings& settings) {
  expects(place.z == 0, "a foot stands on the plate");
  // Shares of the difference between the branch's radius and the foot's, in the order in which they are
  // tried.
  constexpr std::array<double, 6> kWidenings{1, 0.8, 0.6, 0.4, 0.2, 0};
  const double wide = std::max(settings.foot_diameter.count() / 2, radius_mm);
  double base = radius_mm;
  for (const double widening : kWidenings) {
    base = radius_mm + (wide - radius_mm) * widening;
    if (field.has_room(place, base)) break;
  }
  // A branch that arrives aslant may have no room straight above.
  PlatePoint top{place.x, place.y, settings.foot_height.count()};
  while (top.z > kLowest_mm && !field.has_room(PlateSegment{place, top}, radius_mm))
    top.z /= 2;
  return {place, top, base, radius_mm};
}

}  // namespace contourd
