#include "core/routing/contact_neighbours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/support/plate_segment.hpp"

namespace contourd {
namespace {

constexpr std::array<double, 3> kDistances_mm{0.3, 0.6, 0.9};
// How far the surface may lie above or below the contact.
constexpr double kAcross_mm = 0.6;

// True if the material at height z is continuous from one place to the other.
bool is_connected(const PlatePoint& from, const PlatePoint& to, double z, const LitLayers& layers) {
  const int steps = static_cast<int>(std::hypot(to.x - from.x, to.y - from.y) / layers.pitch_mm()) + 1;
  for (int i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    if (!layers.is_lit({from.x + (to.x - from.x) * part, from.y + (to.y - from.y) * part, z})) return false;
  }
  return true;
}

}  // namespace

std::vector<SupportContact> neighbours_of(const SupportContact& contact, const LitLayers& layers,
                                          IslandHold hold) {
  const bool is_island = contact.cause == ContactCause::Island;
  const bool in_first_layer = is_island && hold == IslandHold::FromItsFirstLayer;
  // A layer is lit from its middle up, so an underside within half a step of the contact is in the same
  // layer.
  const double layers_up = in_first_layer ? 0.5 : 2;
  const double up = is_island ? layers_up * layers.step_mm() : kAcross_mm;
  const double joined = (in_first_layer ? 0.5 : 1.5) * layers.step_mm();
  std::vector<SupportContact> neighbours;
  for (const double distance : kDistances_mm) {
    for (const Point& direction : kAround) {
      const PlatePoint low{contact.place.x + direction.x * distance, contact.place.y + direction.y * distance,
                           contact.place.z - kAcross_mm};
      const std::optional<double> underside = layers.underside_above(low, kAcross_mm + up);
      if (!underside) continue;
      const PlatePoint place{low.x, low.y, *underside};
      const double inside = std::max(place.z, contact.place.z) + joined;
      if (!is_connected(contact.place, place, inside, layers)) continue;
      SupportContact& neighbour = neighbours.emplace_back(contact);
      neighbour.place = place;
      neighbour.outward = {0, 0, -1};
    }
  }
  return neighbours;
}

}  // namespace contourd
