#include "core/routing/frail_contacts.hpp"

#include <algorithm>
#include <iterator>

namespace contourd {
namespace {

// True if at most one pixel around the point is lit.
bool is_frail_at(const PlatePoint& at, double radius_mm, const LitLayers& layers) {
  int lit = 0;
  for (double y = -radius_mm; y <= radius_mm; y += layers.pitch_mm()) {
    for (double x = -radius_mm; x <= radius_mm; x += layers.pitch_mm())
      if (layers.is_lit({at.x + x, at.y + y, at.z}) && ++lit > 1) return false;
  }
  return true;
}

}  // namespace

std::vector<SupportContact> frail_contacts(std::span<const SupportContact> contacts, const LitLayers& layers,
                                           const SupportSettings& settings) {
  const double radius = settings.tip_diameter.count() / 2;
  // The part begins up to a step above the contact.
  const double depth = settings.tip_depth.count() + layers.step_mm();
  std::vector<SupportContact> frail;
  std::ranges::copy_if(contacts, std::back_inserter(frail), [&](const SupportContact& contact) {
    PlatePoint at = contact.place;
    for (; at.z <= contact.place.z + depth; at.z += layers.step_mm())
      if (!is_frail_at(at, radius, layers)) return false;
    return true;
  });
  return frail;
}

}  // namespace contourd
