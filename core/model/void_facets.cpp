#include "core/model/void_facets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/geometry/boxes.hpp"
#include "core/geometry/vertex_numbers.hpp"

namespace contourd {
namespace {

// A facet narrower than this falls between the pixels of any projector.
constexpr double kThinMm = 0.02;
// The width of a thin facet as a part of the model's diagonal, for files whose unit is not the millimetre.
constexpr double kThinPart = 1.0 / 500;

double diagonal_of(const Bounds& bounds) {
  return std::hypot(bounds.size_x(), bounds.size_y(), bounds.size_z());
}

// True if facets in the boxes may be joined, or make a group that is wide enough to print.
bool are_near(const Bounds& a, const Bounds& b) {
  constexpr double kNearMm = 10 * kThinMm;
  return a.min_x - kNearMm <= b.max_x && b.min_x <= a.max_x + kNearMm && a.min_y - kNearMm <= b.max_y &&
         b.min_y <= a.max_y + kNearMm && a.min_z - kNearMm <= b.max_z && b.min_z <= a.max_z + kNearMm;
}

bool is_thin(const Facet& facet, double thin_mm) {
  const auto& [a, b, c] = facet.vertices;
  const auto apart = [](const Vertex& from, const Vertex& to) {
    return std::hypot(double{to.x} - from.x, double{to.y} - from.y, double{to.z} - from.z);
  };
  return twice_area(facet) < thin_mm * std::max({apart(a, b), apart(b, c), apart(c, a)});
}

// Calls look(facet, the box around it) for the facets of all chunks of which may_matter(the box around it).
// Few chunks of a sound model matter, and the box of a chunk takes a tenth of the time of its facets' boxes.
template <typename MayMatter, typename Look>
void look_at_chunks(std::span<const Facet> facets, const MayMatter& may_matter, const Look& look) {
  constexpr std::size_t kChunk = 64;
  while (!facets.empty()) {
    const std::span<const Facet> chunk = facets.first(std::min(kChunk, facets.size()));
    facets = facets.subspan(chunk.size());
    if (!may_matter(contourd::bounds_of(chunk))) continue;
    for (const Facet& facet : chunk)
      look(facet, box_around(facet));
  }
}

struct Boxes {
  Bounds wide;  // around the facets that are not thin
  Bounds all;   // around all facets
};

Boxes boxes_of(std::span<const Facet> facets, double thin_mm) {
  Boxes boxes;
  const auto may_extend = [&boxes](const Bounds& around) {
    extend(boxes.all, around);
    return !contains(boxes.wide, around);
  };
  look_at_chunks(facets, may_extend, [&](const Facet& facet, const Bounds& around) {
    if (!contains(boxes.wide, around) && !is_thin(facet, thin_mm)) extend(boxes.wide, around);
  });
  return boxes;
}

// Returns by facet whether as many facets are turned one way as the other over the facet's vertices.
std::vector<bool> cancelled(std::span<const Facet> facets) {
  struct Turned {
    Corners sorted;
    std::uint32_t facet;
    int direction;
  };
  const std::vector<Corners> corners = number_vertices(facets);
  std::vector<Turned> all;
  all.reserve(facets.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const auto [a, b, c] = corners[f];
    const int direction = (a < b) + (b < c) + (c < a) == 2 ? 1 : -1;
    Corners sorted = corners[f];
    std::sort(sorted.begin(), sorted.end());
    all.push_back({sorted, f, direction});
  }
  std::ranges::sort(all, {}, [](const Turned& each) { return std::pair(each.sorted, each.facet); });
  std::vector<bool> cancel(facets.size());
  for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
    int net = 0;
    for (; end < all.size() && all[end].sorted == all[i].sorted; ++end)
      net += all[end].direction;
    for (std::size_t at = i; at < end; ++at)
      cancel[all[at].facet] = net == 0;
  }
  return cancel;
}

// The most facets at a side of a box that are compared with each other. A surface of the model may lie in the
// side with a million facets; strays are few.
constexpr std::size_t kMostAtSide = 4'096;

// True if facets that cancel each other reach a side of the box, and thin ones at most besides.
bool is_side_in_doubt(const Bounds& box, std::span<const Facet> facets, double thin_mm) {
  const auto reached = [&box](const Bounds& around) {
    return std::array{around.min_x <= box.min_x, around.min_y <= box.min_y, around.min_z <= box.min_z,
                      around.max_x >= box.max_x, around.max_y >= box.max_y, around.max_z >= box.max_z};
  };
  std::array<std::vector<Facet>, 6> sides;
  const auto may_add = [&](const Bounds& around) {
    const std::array sides_reached = reached(around);
    for (std::size_t side = 0; side < sides.size(); ++side)
      if (sides_reached[side] && sides[side].size() <= kMostAtSide) return true;
    return false;
  };
  look_at_chunks(facets, may_add, [&](const Facet& facet, const Bounds& around) {
    const std::array sides_reached = reached(around);
    for (std::size_t side = 0; side < sides.size(); ++side)
      if (sides_reached[side] && sides[side].size() <= kMostAtSide) sides[side].push_back(facet);
  });
  return std::ranges::any_of(sides, [thin_mm](const std::vector<Facet>& side) {
    if (side.size() > kMostAtSide) return false;
    const std::vector<bool> cancel = cancelled(side);
    if (std::find(cancel.begin(), cancel.end(), true) == cancel.end()) return false;
    for (std::size_t f = 0; f < side.size(); ++f)
      if (!cancel[f] && !is_thin(side[f], thin_mm)) return false;
    return true;
  });
}

// Returns the box around the facets in doubt, empty if there are none; narrows thin_mm for a small model.
Bounds bounds_in_doubt(std::span<const Facet> facets, double& thin_mm) {
  Boxes boxes = boxes_of(facets, thin_mm);
  if (boxes.wide.empty()) return {};
  if (const double part = kThinPart * diagonal_of(boxes.wide); part < thin_mm) {
    thin_mm = part;
    boxes = boxes_of(facets, thin_mm);
  }
  if (is_side_in_doubt(boxes.all, facets, thin_mm)) return boxes.all;
  Bounds in_doubt;
  if (contains(boxes.wide, boxes.all)) return in_doubt;
  const auto reaches_out = [&boxes](const Bounds& around) { return !contains(boxes.wide, around); };
  look_at_chunks(facets, reaches_out, [&](const Facet&, const Bounds& around) {
    if (reaches_out(around)) extend(in_doubt, around);
  });
  return in_doubt;
}

// Returns the facet with its vertices moved to the nearest points of a grid, so that vertices that differ by
// rounding become one.
Facet snapped(const Facet& facet) {
  const auto nearest = [](float coordinate) {
    return static_cast<float>(std::round(coordinate / kThinMm) * kThinMm);
  };
  Facet moved = facet;
  for (Vertex& v : moved.vertices)
    v = {nearest(v.x), nearest(v.y), nearest(v.z)};
  return moved;
}

// Facets that are joined to each other at vertices, as a union-find forest of the vertices.
class Groups {
 public:
  explicit Groups(std::span<const Facet> facets) {
    std::vector<Facet> moved(facets.size());
    std::ranges::transform(facets, moved.begin(), snapped);
    corners_ = number_vertices(moved);
    std::uint32_t vertices = 0;
    for (const Corners& c : corners_)
      vertices = std::max({vertices, c[0] + 1, c[1] + 1, c[2] + 1});
    parent_.resize(vertices);
    std::iota(parent_.begin(), parent_.end(), 0U);
    for (const Corners& c : corners_) {
      for (const std::uint32_t other : {c[1], c[2]}) {
        const std::uint32_t a = root_of(c[0]), b = root_of(other);
        parent_[std::max(a, b)] = std::min(a, b);
      }
    }
  }

  [[nodiscard]] std::size_t size() const { return parent_.size(); }
  // Returns the number of the facet's group, below size().
  [[nodiscard]] std::uint32_t of(std::size_t facet) { return root_of(corners_[facet][0]); }

 private:
  std::uint32_t root_of(std::uint32_t vertex) {
    while (parent_[vertex] != vertex)
      vertex = parent_[vertex] = parent_[parent_[vertex]];
    return vertex;
  }

  std::vector<Corners> corners_;
  std::vector<std::uint32_t> parent_;
};

// Returns by facet whether its group encloses nothing.
std::vector<bool> in_void_groups(std::span<const Facet> facets, double thin_mm) {
  struct Group {
    double twice_area = 0;
    Bounds around{};
    bool has_wide = false;
  };
  const std::vector<bool> cancel = cancelled(facets);
  Groups groups(facets);
  std::vector<Group> figures(groups.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    Group& group = figures[groups.of(f)];
    extend(group.around, box_around(facets[f]));
    if (cancel[f]) continue;
    group.twice_area += twice_area(facets[f]);
    group.has_wide = group.has_wide || !is_thin(facets[f], thin_mm);
  }
  std::vector<bool> is_void(facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const Group& group = figures[groups.of(f)];
    is_void[f] = !group.has_wide && group.twice_area <= thin_mm * diagonal_of(group.around);
  }
  return is_void;
}

}  // namespace

std::optional<std::vector<bool>> void_facets(std::span<const Facet> facets) {
  expects(facets.size() < kMaxFacets, "there are fewer than 2^30 facets");
  double thin_mm = kThinMm;
  const Bounds in_doubt = bounds_in_doubt(facets, thin_mm);
  if (in_doubt.empty()) return std::nullopt;
  std::vector<Facet> nearby;
  std::vector<std::size_t> numbers;
  Bounds box;  // around all facets that count
  for (std::size_t f = 0; f < facets.size(); ++f) {
    if (const Bounds around = box_around(facets[f]); are_near(around, in_doubt)) {
      nearby.push_back(facets[f]);
      numbers.push_back(f);
    } else {
      extend(box, around);
    }
  }
  const std::vector<bool> is_void = in_void_groups(nearby, thin_mm);
  for (std::size_t i = 0; i < nearby.size(); ++i)
    if (!is_void[i]) extend(box, box_around(nearby[i]));
  if (box.empty()) return std::nullopt;
  std::vector<bool> found(facets.size());
  for (std::size_t i = 0; i < nearby.size(); ++i)
    found[numbers[i]] = is_void[i] && !contains(box, box_around(nearby[i]));
  const bool any = std::find(found.begin(), found.end(), true) != found.end();
  return any ? std::optional(std::move(found)) : std::nullopt;
}

}  // namespace contourd
