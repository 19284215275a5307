#include "core/orientation/exposed_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "core/orientation/rated_mesh.hpp"
#include "core/repair/facet_patches.hpp"
#include "core/repair/winding_probe.hpp"

namespace contourd {
namespace {

// Bodies that come this near touch: half a layer.
constexpr double kTouchMm = 0.025;
// One point of a facet is probed for each part of this area, up to a limit.
constexpr double kProbedMm2 = 4;
constexpr double kMostPoints = 64;
// Limit on the faces that rays look at in all.
constexpr std::size_t kMostLooks = 30'000'000;

void include(Bounds& bounds, const Facet& facet) {
  for (const Vertex& v : facet.vertices) {
    bounds = {std::min<double>(bounds.min_x, v.x), std::min<double>(bounds.min_y, v.y),
              std::min<double>(bounds.min_z, v.z), std::max<double>(bounds.max_x, v.x),
              std::max<double>(bounds.max_y, v.y), std::max<double>(bounds.max_z, v.z)};
  }
}

bool are_near(const Bounds& a, const Bounds& b) {
  const auto meet = [](double a_min, double a_max, double b_min, double b_max) {
    return a_min <= b_max + kTouchMm && b_min <= a_max + kTouchMm;
  };
  return meet(a.min_x, a.max_x, b.min_x, b.max_x) && meet(a.min_y, a.max_y, b.min_y, b.max_y) &&
         meet(a.min_z, a.max_z, b.min_z, b.max_z);
}

// The bodies of a mesh: the patches of facets that are connected by edges. Bodies that share vertices are not
// one body.
class Bodies {
 public:
  Bodies(std::span<const Facet> facets, const FacetPatches& mesh)
      : mesh_(mesh), bounds_(mesh.patches.size()) {
    for (std::size_t f = 0; f < facets.size(); ++f) {
      if (mesh.face_of[f] != FacetPatches::kNone) include(bounds_[body_of(f)], facets[f]);
    }
  }

  // True if a facet comes near the bounds of another body, or if there are too many bodies to find out.
  [[nodiscard]] bool may_meet_another(std::size_t number, const Facet& facet) const {
    if (mesh_.face_of[number] == FacetPatches::kNone) return false;
    if (bounds_.size() > kMostBodies) return true;
    Bounds bounds;
    include(bounds, facet);
    for (std::uint32_t body = 0; body < bounds_.size(); ++body) {
      if (body != body_of(number) && are_near(bounds, bounds_[body])) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kMostBodies = 256;

  [[nodiscard]] std::uint32_t body_of(std::size_t facet) const {
    return mesh_.places[mesh_.face_of[facet]].patch;
  }

  const FacetPatches& mesh_;
  std::vector<Bounds> bounds_;  // by body
};

struct Probe {
  const FacetPatches& mesh;
  WindingProbe rays;
};

// Returns how often the mesh winds around a point: as most of the rays say.
int winding_at(Probe& probe, const SpacePoint& point) {
  WindingProbe::Windings windings =
      probe.rays.windings_around(point, [&](std::uint32_t face) { return int{probe.mesh.faces[face].net}; });
  std::ranges::sort(windings);
  return windings[windings.size() / 2 - 1];
}

// Returns the part of a facet that counts, from evenly spread points just outside and just inside of it.
double exposed_part(Probe& probe, const Facet& facet) {
  const Vertex &a = facet.vertices[0], &b = facet.vertices[1], &c = facet.vertices[2];
  const Direction area = area_of(facet);
  const double size = length_of(area), step = kTouchMm / size;
  const auto points = static_cast<int>(std::clamp(size / kProbedMm2, 1.0, kMostPoints));
  double exposed = 0;
  for (int i = 0; i < points; ++i) {
    // The R2 sequence (Roberts), folded into the triangle. Its points lie on no symmetry of a mesh.
    double u = std::fmod(0.5 + 0.7548776662466927 * (i + 1), 1.0);
    double v = std::fmod(0.5 + 0.5698402909980532 * (i + 1), 1.0);
    if (u + v > 1) std::tie(u, v) = std::pair(1 - u, 1 - v);
    const auto at = [&](double along) {
      return SpacePoint{a.x + u * (double{b.x} - a.x) + v * (double{c.x} - a.x) + along * area.x,
                        a.y + u * (double{b.y} - a.y) + v * (double{c.y} - a.y) + along * area.y,
                        a.z + u * (double{b.z} - a.z) + v * (double{c.z} - a.z) + along * area.z};
    };
    if (winding_at(probe, at(step)) > 0) continue;
    exposed += 1.0 / std::max(winding_at(probe, at(-step)), 1);
  }
  return exposed / points;
}

}  // namespace

std::vector<double> exposed_parts(std::span<const Facet> facets) {
  const FacetPatches mesh = patches_of(facets);
  if (mesh.patches.size() < 2) return {};
  const Bodies bodies(facets, mesh);
  std::vector<std::pair<double, std::uint32_t>> doubtful;  // areas, facets
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const double size = length_of(area_of(facets[f]));
    if (size > 0 && bodies.may_meet_another(f, facets[f])) doubtful.emplace_back(-size, f);
  }
  if (doubtful.empty()) return {};
  std::ranges::sort(doubtful);
  Probe probe{mesh, WindingProbe(facets, mesh.faces)};
  std::vector<double> parts(facets.size(), 1.0);
  for (const auto& [size, facet] : doubtful) {
    if (probe.rays.looks() > kMostLooks) break;
    parts[facet] = exposed_part(probe, facets[facet]);
  }
  return parts;
}

}  // namespace contourd
