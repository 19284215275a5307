#include "core/model/stray_facets.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/boxes.hpp"
#include "core/model/void_facets.hpp"

namespace contourd {
namespace {

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
      const Bounds around = box_around(facet);
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

// The facets of one kind that were dropped.
struct Dropped {
  std::string_view kind;  // "without area"
  std::size_t facets = 0;
  Vertex first{};  // place of the first one

  void add(std::size_t more, const Vertex& place) {
    if (facets == 0) first = place;
    facets += more;
  }
};

std::string warning_about(const Dropped& dropped) {
  const std::string at =
      text_of(dropped.first.x) + ", " + text_of(dropped.first.y) + ", " + text_of(dropped.first.z) + " mm";
  const std::string kind(dropped.kind);
  return dropped.facets == 1
             ? "one facet " + kind + " lies outside the rest of the model and is left out: it is at " + at
             : std::to_string(dropped.facets) + " facets " + kind +
                   " lie outside the rest of the model and are left out: the first is at " + at;
}

void drop_facets_without_area(std::vector<Facet>& facets, Dropped& dropped) {
  const AreaBounds bounds = bounds_of_areas(facets);
  if (bounds.box.empty() || !bounds.may_leave_facets) return;
  const auto is_stray = [&bounds](const Facet& facet) { return !contains(bounds.box, box_around(facet)); };
  const auto first = std::ranges::find_if(facets, is_stray);
  if (first == facets.end()) return;
  const Vertex place = first->vertices[0];
  dropped.add(std::erase_if(facets, is_stray), place);
}

void drop_void_facets(std::vector<Facet>& facets, Dropped& dropped) {
  const std::optional<std::vector<bool>> is_void = void_facets(facets);
  if (!is_void) return;
  const auto first =
      static_cast<std::size_t>(std::find(is_void->begin(), is_void->end(), true) - is_void->begin());
  const Vertex place = facets[first].vertices[0];
  std::size_t left = first;
  for (std::size_t f = first; f < facets.size(); ++f)
    if (!(*is_void)[f]) facets[left++] = facets[f];
  dropped.add(facets.size() - left, place);
  facets.resize(left);
}

}  // namespace

void drop_stray_facets(Model& model) {
  // Each round makes the model's box smaller, so that other facets may reach out of it.
  constexpr int kRounds = 8;
  Dropped without_area{"without area"}, enclosing_nothing{"enclosing nothing"};
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t before = model.facets.size();
    drop_facets_without_area(model.facets, without_area);
    drop_void_facets(model.facets, enclosing_nothing);
    if (model.facets.size() == before) break;
  }
  for (const Dropped& dropped : {without_area, enclosing_nothing})
    if (dropped.facets > 0) model.warnings.push_back(warning_about(dropped));
}

}  // namespace contourd
