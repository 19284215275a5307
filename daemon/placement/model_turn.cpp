#include "daemon/placement/model_turn.hpp"

#include <algorithm>

namespace contourd {
namespace {

// Returns the height that models with `fit` leave free beneath them, since they may have to stand on
// supports, a whole number of layers high.
double room_for_supports_mm(const JobSettings& settings) {
  if (!adds_supports(settings.supports)) return 0;
  return (settings.resin.supports.lift + to_millimeters(settings.resin.layer_height_max)).count();
}

// Returns the scale at which the model fills the display, as in the thesis's equations 3.6 to 3.19, but equal
// in all three directions, since a printed part must keep its shape, and no higher than the machine can
// print.
double scale_to_fit(const Bounds& bounds, const BuildVolume& volume, double beneath_mm) {
  const double pixels_per_mm = PixelMap::fit(volume.display, bounds).pixels_per_mm();
  // If the machine is hardly higher than the supports, the model gets half of its height.
  const double height_mm = std::max(volume.height_mm - beneath_mm, volume.height_mm / 2);
  return std::min(pixels_per_mm * volume.pitch_mm(), height_mm / bounds.size_z());
}

}  // namespace

void turn_and_scale(std::span<Facet> facets, const ModelTicket& ticket, const Scale& shrinkage) {
  Orientation turn{ticket.rotation.x, ticket.rotation.y, ticket.rotation.z, shrinkage, ticket.up};
  if (!ticket.fit) turn.scale = ticket.scale.value_or(Scale{}) * shrinkage;
  orient(facets, turn);
}

void enlarge(std::span<Facet> facets, const Scale& scale) {
  Orientation enlarged;
  enlarged.scale = scale;
  orient(facets, enlarged);
}

Scale turn_to_size(std::span<Facet> facets, const ModelTicket& ticket, const BuildVolume& volume,
                   const JobSettings& settings) {
  turn_and_scale(facets, ticket, settings.resin.shrinkage_factors);
  if (!ticket.fit) return ticket.scale.value_or(Scale{});
  const Scale scale{scale_to_fit(bounds_of(facets), volume, room_for_supports_mm(settings))};
  enlarge(facets, scale);
  return scale;
}

}  // namespace contourd
