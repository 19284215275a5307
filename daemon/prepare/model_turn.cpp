#include "daemon/prepare/model_turn.hpp"

namespace contourd {

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

}  // namespace contourd
