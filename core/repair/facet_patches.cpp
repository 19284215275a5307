#include "core/repair/facet_patches.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "core/geometry/point_hash.hpp"

namespace contourd {
namespace {

// Edges are collected for this many vertices at a time, which bounds the memory.
constexpr std::uint32_t kVerticesAtATime = 1U << 17U;

// A junction of more sides than this says nothing about its patches and is ignored.
constexpr std::size_t kMaxParts = 64;

Corners sorted(Corners corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

// True if the vertices have the same cyclic order.
bool turned_alike(const Corners& a, const Corners& b) {
  const auto at = static_cast<std::size_t>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(at + 1) % 3] == a[1];
}

template <typename Number>
void count(Number& number, int change) {
  if (number < std::numeric_limits<Number>::max() && number > std::numeric_limits<Number>::min() - change)
    number = static_cast<Number>(number + change);
}

void find_faces(std::span<const Facet> facets, FacetPatches& found) {
  const std::vector<Corners> corners = number_vertices(facets);
  found.face_of.assign(facets.size(), FacetPatches::kNone);
  found.faces.reserve(facets.size());
  std::vector<std::uint32_t> slots(std::bit_ceil(facets.size() + facets.size() / 2 + 1), FacetPatches::kNone);
  const std::size_t last = slots.size() - 1;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    if (is_degenerate(corners[f])) continue;
    const Corners key = sorted(corners[f]);
    std::size_t slot = mixed(std::uint64_t{key[0]} << 32U | key[1], key[2]) & last;
    while (slots[slot] != FacetPatches::kNone && sorted(found.faces[slots[slot]].corners) != key)
      slot = (slot + 1) & last;
    if (slots[slot] == FacetPatches::kNone) {
      slots[slot] = static_cast<std::uint32_t>(found.faces.size());
      found.faces.push_back({corners[f], f, 0, 0});
    }
    Face& face = found.faces[slots[slot]];
    count(face.copies, 1);
    count(face.net, turned_alike(face.corners, corners[f]) ? 1 : -1);
    found.face_of[f] = slots[slot];
  }
}

// Patches while they grow together, as a union-find forest: each face refers to another face of its patch, up
// to the root that stands for all of them, and knows whether the two are turned against each other.
class GrowingPatches {
 public:
  explicit GrowingPatches(std::size_t faces) : parent_(faces), broken_(faces, false) {
    for (std::uint32_t i = 0; i < faces; ++i)
      parent_[i] = 2 * i;
  }

  struct Root {
    std::uint32_t face;
    std::uint32_t reversed;  // 0 or 1
  };

  Root root_of(std::uint32_t face) {
    std::uint32_t reversed = 0;
    std::uint32_t at = face;
    while (parent_[at] / 2 != at) {
      reversed ^= parent_[at] & 1U;
      at = parent_[at] / 2;
    }
    // Path compression: the next search from these faces is short.
    for (std::uint32_t rest = reversed; face != at;) {
      const std::uint32_t next = parent_[face];
      parent_[face] = 2 * at + rest;
      rest ^= next & 1U;
      face = next / 2;
    }
    return {at, reversed};
  }

  void join(std::uint32_t a, std::uint32_t b, bool reversed) {
    const Root one = root_of(a), other = root_of(b);
    const std::uint32_t against = one.reversed ^ other.reversed ^ static_cast<std::uint32_t>(reversed);
    const auto [low, high] = std::minmax(one.face, other.face);
    if (low == high) {
      if (against != 0) broken_[low] = true;
      return;
    }
    parent_[high] = 2 * low + against;
    if (broken_[high]) broken_[low] = true;
  }

  [[nodiscard]] bool is_broken(std::uint32_t root) const { return broken_[root]; }

 private:
  std::vector<std::uint32_t> parent_;  // twice the parent's number, plus 1 if turned against the parent
  std::vector<bool> broken_;  // by root: a face of the patch was joined to itself, turned the other way
};

struct Side {
  std::uint32_t high;  // the higher vertex
  std::uint32_t face : 30;
  std::uint32_t index : 2;  // the face's corner at which the side begins
};

struct SideAtJunction {
  std::uint32_t junction, face;
  std::int32_t direction;  // 1: from the lower vertex to the higher; -1: back
};

class PatchFinder {
 public:
  explicit PatchFinder(FacetPatches& found)
      : found_(found), growing_(found.faces.size()), meets_many_(found.faces.size(), false) {}

  void find() {
    std::uint32_t vertices = 0;
    for (const Face& face : found_.faces)
      vertices = std::max({vertices, face.corners[0] + 1, face.corners[1] + 1, face.corners[2] + 1});
    for (std::uint32_t first = 0; first < vertices; first += kVerticesAtATime)
      visit_edges_from(first, std::min(vertices - first, kVerticesAtATime));
    judge_unequal();
    number_patches();
    collect_junctions();
  }

 private:
  // Visits the edges whose lower vertex is one of `count` vertices from `first` on.
  void visit_edges_from(std::uint32_t first, std::uint32_t count) {
    starts_.assign(count + 1, 0);
    const auto each_side = [&](auto&& visit) {
      for (std::uint32_t f = 0; f < found_.faces.size(); ++f) {
        const Corners& c = found_.faces[f].corners;
        for (std::uint32_t i = 0; i < 3; ++i) {
          const auto [low, high] = std::minmax(c[i], c[(i + 1) % 3]);
          if (low - first < count) visit(low - first, Side{high, f & 0x3FFFFFFFU, i & 3U});
        }
      }
    };
    each_side([this](std::uint32_t low, const Side&) { ++starts_[low + 1]; });
    for (std::size_t i = 1; i < starts_.size(); ++i)
      starts_[i] += starts_[i - 1];
    sides_.resize(starts_.back());
    next_.assign(starts_.begin(), starts_.end() - 1);
    each_side([this](std::uint32_t low, const Side& side) { sides_[next_[low]++] = side; });
    for (std::uint32_t i = 0; i < count; ++i)
      visit_edges_of(std::span(sides_).subspan(starts_[i], starts_[i + 1] - starts_[i]));
  }

  void visit_edges_of(std::span<Side> sides) {
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return a.high != b.high ? a.high < b.high : a.face < b.face;
    });
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i;
      while (end < sides.size() && sides[end].high == sides[i].high)
        ++end;
      visit_edge(sides.subspan(i, end - i));
      i = end;
    }
  }

  void visit_edge(std::span<const Side> sides) {
    if (sides.size() == 1) {
      const Corners& c = found_.faces[sides[0].face].corners;
      found_.boundary_edges.push_back(
          {sides[0].face, c[sides[0].index], c[(std::size_t{sides[0].index} + 1) % 3]});
    } else if (sides.size() > 2) {
      add_junction_of(sides);
    } else if (is_wall(sides[0].face) != is_wall(sides[1].face)) {
      unequal_.insert(unequal_.end(), sides.begin(), sides.end());
    } else {
      join(sides[0], sides[1]);
    }
  }

  // True if the file has the face an even number of times, like a wall between two solids.
  [[nodiscard]] bool is_wall(std::uint32_t face) const { return found_.faces[face].copies % 2 == 0; }

  void join(const Side& a, const Side& b) {
    growing_.join(a.face, b.face, runs_upwards(a) == runs_upwards(b));
  }

  void add_junction_of(std::span<const Side> sides) {
    for (const Side& side : sides) {
      at_junctions_.push_back({found_.junctions, side.face, runs_upwards(side) ? 1 : -1});
      meets_many_[side.face] = true;
    }
    ++found_.junctions;
  }

  // Decides about the edges where a wall meets a surface. A wall that also meets several faces separates two
  // solids, and the rest of the surface is missing here: the two are not joined.
  void judge_unequal() {
    for (std::size_t i = 0; i < unequal_.size(); i += 2) {
      const Side &a = unequal_[i], &b = unequal_[i + 1];
      if (meets_many_[is_wall(a.face) ? a.face : b.face]) {
        add_junction_of(std::span(unequal_).subspan(i, 2));
      } else {
        join(a, b);
      }
    }
  }

  [[nodiscard]] bool runs_upwards(const Side& side) const {
    return found_.faces[side.face].corners[side.index] != side.high;
  }

  void number_patches() {
    found_.places.resize(found_.faces.size());
    for (std::uint32_t f = 0; f < found_.faces.size(); ++f) {
      const GrowingPatches::Root root = growing_.root_of(f);
      if (root.face == f) {
        found_.patches.emplace_back();
        found_.patches.back().first_face = f;
        found_.patches.back().orientable = !growing_.is_broken(f);
        found_.places[f] = {static_cast<std::uint32_t>(found_.patches.size() - 1) & 0x7FFFFFFFU, 0};
      } else {
        // The root has the lowest number of its patch.
        found_.places[f] = {found_.places[root.face].patch, root.reversed & 1U};
      }
    }
    for (const BoundaryEdge& edge : found_.boundary_edges)
      ++found_.patches[found_.places[edge.face].patch].boundary_edges;
  }

  void collect_junctions() {
    std::vector<JunctionPart> parts;
    for (std::size_t i = 0; i < at_junctions_.size();) {
      parts.clear();
      const std::uint32_t junction = at_junctions_[i].junction;
      for (; i < at_junctions_.size() && at_junctions_[i].junction == junction; ++i) {
        const FacePlace place = found_.places[at_junctions_[i].face];
        parts.push_back({junction, place.patch,
                         place.reversed != 0 ? -at_junctions_[i].direction : at_junctions_[i].direction});
      }
      if (parts.size() <= kMaxParts) add_junction(parts);
    }
  }

  void add_junction(std::vector<JunctionPart>& parts) {
    std::sort(parts.begin(), parts.end(),
              [](const JunctionPart& a, const JunctionPart& b) { return a.patch < b.patch; });
    for (std::size_t i = 0; i < parts.size();) {
      JunctionPart sum = parts[i];
      for (++i; i < parts.size() && parts[i].patch == sum.patch; ++i)
        sum.sides += parts[i].sides;
      if (sum.sides != 0) found_.junction_parts.push_back(sum);
    }
  }

  FacetPatches& found_;
  GrowingPatches growing_;
  std::vector<std::uint32_t> starts_, next_;  // offsets in sides_, by lower vertex
  std::vector<Side> sides_;
  std::vector<bool> meets_many_;  // by face: meets more than one other face over an edge
  std::vector<Side> unequal_;     // in pairs: the two sides of an edge where a wall meets a surface
  std::vector<SideAtJunction> at_junctions_;
};

void measure(std::span<const Facet> facets, const Bounds& bounds, FacetPatches& found) {
  const Point center = bounds.center();
  const double center_z = (bounds.min_z + bounds.max_z) / 2;
  for (std::uint32_t f = 0; f < found.faces.size(); ++f) {
    const Face& face = found.faces[f];
    Patch& patch = found.patches[found.places[f].patch];
    const int sign = found.places[f].reversed != 0 ? -1 : 1;
    const auto& [a, b, c] = facets[face.facet].vertices;
    const double ax = a.x - center.x, ay = a.y - center.y, az = a.z - center_z;
    const double ux = b.x - double{a.x}, uy = b.y - double{a.y}, uz = b.z - double{a.z};
    const double vx = c.x - double{a.x}, vy = c.y - double{a.y}, vz = c.z - double{a.z};
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    patch.area += std::sqrt(nx * nx + ny * ny + nz * nz) / 2;
    patch.six_volumes += sign * (ax * nx + ay * ny + az * nz);
    patch.area_x += sign * nx;
    patch.area_y += sign * ny;
    patch.area_z += sign * nz;
    const std::int32_t net = sign * face.net;
    patch.least_net = patch.faces == 0 ? net : std::min(patch.least_net, net);
    patch.most_net = patch.faces == 0 ? net : std::max(patch.most_net, net);
    patch.net += net;
    ++patch.with_net[Patch::place_of(net)];
    patch.most_copies = std::max(patch.most_copies, face.copies);
    patch.odd += face.copies % 2U;
    patch.odd_half += face.copies / 2U % 2U;
    ++patch.faces;
  }
}

}  // namespace

FacetPatches patches_of(std::span<const Facet> facets) {
  FacetPatches found;
  find_faces(facets, found);
  PatchFinder(found).find();
  measure(facets, bounds_of(facets), found);
  return found;
}

}  // namespace contourd
