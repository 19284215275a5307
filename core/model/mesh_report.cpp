#include "core/model/mesh_report.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include "core/geometry/vertex_numbers.hpp"

namespace contourd {
namespace {

struct Edge {
  std::uint32_t low, high;  // vertex numbers
  std::int32_t direction;   // +1 from low to high
};

void count_edges(const std::vector<Corners>& corners, MeshReport& report) {
  std::vector<Edge> edges;
  edges.reserve(corners.size() * 3);
  for (const Corners& c : corners) {
    if (is_degenerate(c)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = c[i], to = c[(i + 1) % 3];
      edges.push_back(from < to ? Edge{from, to, 1} : Edge{to, from, -1});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
  report.watertight = !edges.empty();
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    std::int32_t balance = 0;
    for (; end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high; ++end) {
      balance += edges[end].direction;
    }
    const std::size_t facets = end - i;
    report.open_edges += facets == 1;
    report.non_manifold_edges += facets > 2;
    report.flipped_edges += facets == 2 && balance != 0;
    report.watertight = report.watertight && facets % 2 == 0 && balance == 0;
    i = end;
  }
}

// Joins the vertices of each facet and counts the groups.
std::uint64_t count_parts(const std::vector<Corners>& corners) {
  std::uint32_t last = 0;
  for (const Corners& c : corners)
    last = std::max({last, c[0], c[1], c[2]});
  std::vector<std::uint32_t> parent(corners.empty() ? 0 : last + std::size_t{1});
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root_of = [&parent](std::uint32_t vertex) {
    while (parent[vertex] != vertex)
      vertex = parent[vertex] = parent[parent[vertex]];
    return vertex;
  };
  std::uint64_t parts = parent.size();
  for (const Corners& c : corners) {
    for (const std::uint32_t other : {c[1], c[2]}) {
      const std::uint32_t a = root_of(c[0]), b = root_of(other);
      parts -= a != b ? 1 : 0;
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  return parts;
}

void count_duplicates(std::vector<Corners> corners, MeshReport& report) {
  std::erase_if(corners, is_degenerate);
  for (Corners& c : corners)
    std::sort(c.begin(), c.end());
  std::sort(corners.begin(), corners.end());
  const auto unique_end = std::unique(corners.begin(), corners.end());
  report.duplicate_facets = static_cast<std::uint64_t>(corners.end() - unique_end);
}

}  // namespace

EnclosedVolume enclosed_volume(std::span<const Facet> facets, const Bounds& bounds) {
  if (facets.empty()) return {};
  // All in double: differences of floats would be rounded, or overflow.
  const auto [x, y] = bounds.center();
  const double z = (bounds.min_z + bounds.max_z) / 2;
  double six_volumes = 0;
  // Twice the facets' areas as vectors: their sum is 0 if the facets close. Calculated from a point at a
  // distance d, the volume would differ by d times a third of this area.
  double sum_x = 0, sum_y = 0, sum_z = 0;
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.vertices;
    const double ax = a.x, ay = a.y, az = a.z;
    const double ux = b.x - ax, uy = b.y - ay, uz = b.z - az;
    const double vx = c.x - ax, vy = c.y - ay, vz = c.z - az;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    six_volumes += (ax - x) * nx + (ay - y) * ny + (az - z) * nz;
    sum_x += nx;
    sum_y += ny;
    sum_z += nz;
  }
  const double diagonal = std::hypot(bounds.size_x(), bounds.size_y(), bounds.size_z());
  return {six_volumes / 6, std::hypot(sum_x, sum_y, sum_z) * diagonal / 6};
}

MeshReport inspect_mesh(std::span<const Facet> facets) {
  MeshReport report;
  report.facets = facets.size();
  report.bounds = bounds_of(facets);
  const EnclosedVolume volume = enclosed_volume(facets, report.bounds);
  report.volume_mm3 = volume.mm3;
  report.inside_out = volume.inside_out();
  report.zero_area_facets = static_cast<std::uint64_t>(std::count_if(
      facets.begin(), facets.end(), [](const Facet& facet) { return twice_area(facet) == 0.0; }));
  const std::vector<Corners> corners = number_vertices(facets);
  report.degenerate_facets =
      static_cast<std::uint64_t>(std::count_if(corners.begin(), corners.end(), is_degenerate));
  count_edges(corners, report);
  report.parts = count_parts(corners);
  count_duplicates(corners, report);
  return report;
}

}  // namespace contourd
