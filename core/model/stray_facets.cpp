#include "core/model/stray_facets.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <span>
#include <string>

namespace contourd {
namespace {

bool contains(const Bounds& outer, const Bounds& inner) {
  return outer.min_x <= inner.min_x && outer.min_y <= inner.min_y && outer.min_z <= inner.min_z &&
         outer.max_x >= inner.max_x && outer.max_y >= inner.max_y && outer.max_z >= inner.max_z;
}

void extend(Bounds& bounds, const Bounds& by) {
  bounds = {std::min(bounds.min_x, by.min_x), std::min(bounds.min_y, by.min_y),
            std::min(bounds.min_z, by.min_z), std::max(bounds.max_x, by.max_x),
            std::max(bounds.max_y, by.max_y), std::max(bounds.max_z, by.max_z)};
}

Bounds bounds_of(const Facet& facet) {
  return bounds_of(std::span(&facet, 1));
}

struct AreaBounds {
  Bounds box;                     // around the facets with area
  bool may_leave_facets = false;  // set if a facet without area reached out of the box as far as it was known
};

AreaBounds bounds_of_areas(std::span<const Facet> facets) {
  // In most chunks no facet extends the box, and no area has to be computed.
  constexpr std::size_t kChunk = 64;
  AreaBounds bounds;
  while (!facets.empty()) {
    const std::span<const Facet> chunk = facets.first(std::min(kChunk, facets.size()));
    facets = facets.subspan(chunk.size());
    if (contains(bounds.box, contourd::bounds_of(chunk))) continue;
    for (const Facet& facet : chunk) {
      const Bounds around = bounds_of(facet);
      if (contains(bounds.box, around)) continue;
      if (twice_area(facet) > 0) {
        extend(bounds.box, around);
      } else {
        bounds.may_leave_facets = true;
      }
    }
  }
  return bounds;
}

// Returns the shortest number that is read as this coordinate again.
std::string text_of(float coordinate) {
  std::array<char, 24> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), coordinate).ptr};
}

std::string warning_about(std::size_t facets, const Vertex& place) {
  const std::string at = text_of(place.x) + ", " + text_of(place.y) + ", " + text_of(place.z) + " mm";
  return facets == 1
             ? "one facet without area lies outside the rest of the model and is left out: it is at " + at
             : std::to_string(facets) +
                   " facets without area lie outside the rest of the model and are left out: the first "
                   "is at " +
                   at;
}

}  // namespace

void drop_stray_facets(Model& model) {
  const AreaBounds bounds = bounds_of_areas(model.facets);
  if (bounds.box.empty() || !bounds.may_leave_facets) return;
  const auto is_stray = [&bounds](const Facet& facet) { return !contains(bounds.box, bounds_of(facet)); };
  const auto first = std::ranges::find_if(model.facets, is_stray);
  if (first == model.facets.end()) return;
  const Vertex place = first->vertices[0];
  const std::size_t dropped = std::erase_if(model.facets, is_stray);
  model.warnings.push_back(warning_about(dropped, place));
}

}  // namespace contourd
