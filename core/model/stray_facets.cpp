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

std::string warning_about(std::size_t facets, std::string_view that, const Vertex& place) {
  const std::string at = text_of(place.x) + ", " + text_of(place.y) + ", " + text_of(place.z) + " mm";
  return facets == 1 ? "one facet " + std::string(that) +
                           " lies outside the rest of the model and is left out: it is at " + at
                     : std::to_string(facets) + " facets " + std::string(that) +
                           " lie outside the rest of the model and are left out: the first is at " + at;
}

void drop_facets_without_area(Model& model) {
  const AreaBounds bounds = bounds_of_areas(model.facets);
  if (bounds.box.empty() || !bounds.may_leave_facets) return;
  const auto is_stray = [&bounds](const Facet& facet) { return !contains(bounds.box, box_around(facet)); };
  const auto first = std::ranges::find_if(model.facets, is_stray);
  if (first == model.facets.end()) return;
  const Vertex place = first->vertices[0];
  const std::size_t dropped = std::erase_if(model.facets, is_stray);
  model.warnings.push_back(warning_about(dropped, "without area", place));
}

// Drops facets until none that encloses nothing reaches out of the others: facets that cancel each other may
// show only after slivers further out are gone.
void drop_void_facets(Model& model) {
  constexpr int kPasses = 3;
  std::size_t dropped = 0;
  Vertex place{};
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::optional<std::vector<bool>> is_void = void_facets(model.facets);
    if (!is_void) break;
    const auto first = std::find(is_void->begin(), is_void->end(), true) - is_void->begin();
    if (dropped == 0) place = model.facets[static_cast<std::size_t>(first)].vertices[0];
    std::size_t left = 0;
    for (std::size_t f = 0; f < model.facets.size(); ++f)
      if (!(*is_void)[f]) model.facets[left++] = model.facets[f];
    dropped += model.facets.size() - left;
    model.facets.resize(left);
  }
  if (dropped > 0) model.warnings.push_back(warning_about(dropped, "enclosing nothing", place));
}

}  // namespace

void drop_stray_facets(Model& model) {
  // What is dropped makes the model's box smaller, so that other facets may reach out of it.
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t before = model.facets.size();
    drop_facets_without_area(model);
    drop_void_facets(model);
    if (model.facets.size() == before) return;
  }
}

}  // namespace contourd
