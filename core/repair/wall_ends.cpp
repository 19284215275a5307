#include "core/repair/wall_ends.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace contourd {
namespace {

// Patches continue in each other if ends of their boundary edges are this near: a usual pixel, within which
// the contours of a layer are joined, too.
constexpr double kReachMm = 0.05;

// Limit on the ends compared with one end: the cost of a soup of coinciding ends must not grow with the
// square of its size.
constexpr int kMaxEndsCompared = 1000;

// An end of a patch's boundary edge, and the cube of side kReachMm that it lies in.
struct RimEnd {
  double column, row, level;
  std::uint32_t patch;
  Vertex at;

  [[nodiscard]] auto cube() const { return std::tie(column, row, level); }
};

bool before(const RimEnd& a, const RimEnd& b) {
  return std::tie(a.column, a.row, a.level, a.patch, a.at.x, a.at.y, a.at.z) <
         std::tie(b.column, b.row, b.level, b.patch, b.at.x, b.at.y, b.at.z);
}

bool is_near(const Vertex& a, const Vertex& b) {
  return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z) <= kReachMm;
}

std::vector<RimEnd> rim_ends(std::span<const Facet> facets, const FacetPatches& mesh) {
  std::vector<RimEnd> ends;
  ends.reserve(2 * mesh.boundary_edges.size());
  for (const BoundaryEdge& edge : mesh.boundary_edges) {
    const Face& face = mesh.faces[edge.face];
    for (std::size_t i = 0; i < 3; ++i) {
      if (face.corners[i] != edge.from && face.corners[i] != edge.to) continue;
      const Vertex& at = facets[face.facet].vertices[i];
      ends.push_back({std::floor(at.x / kReachMm), std::floor(at.y / kReachMm), std::floor(at.z / kReachMm),
                      mesh.places[edge.face].patch, at});
    }
  }
  std::sort(ends.begin(), ends.end(), before);
  const auto same = [](const RimEnd& a, const RimEnd& b) { return !before(a, b) && !before(b, a); };
  ends.erase(std::unique(ends.begin(), ends.end(), same), ends.end());
  return ends;
}

// Walls, grouped with the walls beside them.
class WallGroups {
 public:
  WallGroups(std::vector<RimEnd> ends, const std::vector<bool>& walls)
      : ends_(std::move(ends)),
        walls_(walls),
        parent_(walls.size()),
        ends_somewhere_(walls.size(), false),
        goes_on_(walls.size(), false) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  void find() {
    for (const RimEnd& end : ends_) {
      if (walls_[end.patch]) look_around(end);
    }
    for (std::uint32_t p = 0; p < walls_.size(); ++p) {
      const std::uint32_t first = first_of(p);
      if (ends_somewhere_[p]) ends_somewhere_[first] = true;
      if (goes_on_[p]) goes_on_[first] = true;
    }
  }

  [[nodiscard]] bool are_walls(std::uint32_t patch) {
    const std::uint32_t first = first_of(patch);
    return ends_somewhere_[first] && !goes_on_[first];
  }

 private:
  void look_around(const RimEnd& end) {
    bool alone = true;
    int looks = 0;
    for (const double column : {end.column - 1, end.column, end.column + 1}) {
      for (const double row : {end.row - 1, end.row, end.row + 1}) {
        const auto low = std::tuple(column, row, end.level - 1),
                   high = std::tuple(column, row, end.level + 1);
        auto other = std::lower_bound(ends_.begin(), ends_.end(), low,
                                      [](const RimEnd& e, const auto& cube) { return e.cube() < cube; });
        for (; other != ends_.end() && other->cube() <= high; ++other) {
          if (++looks > kMaxEndsCompared) {
            goes_on_[end.patch] = true;
            return;
          }
          if (other->patch == end.patch || !is_near(other->at, end.at)) continue;
          alone = false;
          meet(end.patch, other->patch);
        }
      }
    }
    if (alone) ends_somewhere_[end.patch] = true;
  }

  void meet(std::uint32_t wall, std::uint32_t other) {
    if (!walls_[other]) {
      goes_on_[wall] = true;
      return;
    }
    const std::uint32_t a = first_of(wall), b = first_of(other);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::uint32_t first_of(std::uint32_t patch) {
    while (parent_[patch] != patch)
      patch = parent_[patch] = parent_[parent_[patch]];
    return patch;
  }

  const std::vector<RimEnd> ends_;
  const std::vector<bool>& walls_;
  std::vector<std::uint32_t> parent_;           // by patch: another patch beside it, up to the first
  std::vector<bool> ends_somewhere_, goes_on_;  // by patch
};

}  // namespace

void keep_walls_that_end(std::span<const Facet> facets, const FacetPatches& mesh, std::vector<bool>& walls) {
  if (std::find(walls.begin(), walls.end(), true) == walls.end()) return;
  std::vector<bool> kept(walls.size(), false);
  WallGroups groups(rim_ends(facets, mesh), walls);
  groups.find();
  for (std::uint32_t p = 0; p < walls.size(); ++p)
    kept[p] = walls[p] && groups.are_walls(p);
  walls = std::move(kept);
}

}  // namespace contourd
