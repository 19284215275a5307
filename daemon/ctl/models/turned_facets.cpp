#include "daemon/ctl/models/turned_facets.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <variant>

namespace contourd::ctl {

void turn_facets(std::vector<Facet>& facets, const std::optional<UpOption>& up, double scale) {
  if (!up || facets.empty()) return;
  Orientation orientation;
  if (const auto* const preset = std::get_if<OrientationPreset>(&*up)) {
    ModelTicket ticket;
    ticket.orientation = OrientationTicket{*preset, {}};
    ticket.scale = Scale{scale};
    const ModelOrientation found = find_orientation(facets, ticket, kAnyPrinter).value();
    fmt::print(stderr, "contourctl: {}\n", describe(found));
    orientation.up = found.choice.chosen().up;
  } else {
    orientation.up = std::get<Direction>(*up);
  }
  orient(facets, orientation);
}

}  // namespace contourd::ctl
