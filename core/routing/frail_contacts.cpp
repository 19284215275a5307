#include "core/routing/frail_contacts.hpp"

#include <algorithm>
#include <iterator>

namespace contourd {

std::vector<SupportContact> frail_contacts(std::span<const SupportContact> contacts, const LitLayers& layers,
                                           const SupportSettings& settings) {
  const double radius = settings.tip_diameter.count() / 2;
  // The part begins up to a step above the contact.
  const int steps = static_cast<int>(std::min(settings.tip_depth.count() / layers.step_mm(), 1e3)) + 1;
  std::vector<SupportContact> frail;
  std::ranges::copy_if(contacts, std::back_inserter(frail), [&](const SupportContact& contact) {
    for (int step = 0; step <= steps; ++step) {
      const PlatePoint at{contact.place.x, contact.place.y, contact.place.z + step * layers.step_mm()};
      if (layers.lit_around(at, radius, 2) > 1) return false;
    }
    return true;
  });
  return frail;
}

}  // namespace contourd
