#include "core/repair/boundary_loops.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace contourd {
namespace {

struct End {
  std::uint32_t vertex;
  std::uint32_t edge;
};

// Returns for each boundary edge the number of the first boundary edge of its loop.
std::vector<std::uint32_t> loops_of(std::span<const BoundaryEdge> boundary_edges) {
  std::vector<End> ends;
  for (std::uint32_t i = 0; i < boundary_edges.size(); ++i) {
    ends.push_back({boundary_edges[i].from, i});
    ends.push_back({boundary_edges[i].to, i});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.edge < b.edge;
  });
  std::vector<std::uint32_t> loops(boundary_edges.size());
  std::iota(loops.begin(), loops.end(), 0U);
  const auto first_of = [&loops](std::uint32_t edge) {
    while (loops[edge] != edge)
      edge = loops[edge] = loops[loops[edge]];
    return edge;
  };
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i].vertex != ends[i - 1].vertex) continue;
    const std::uint32_t a = first_of(ends[i - 1].edge), b = first_of(ends[i].edge);
    loops[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t& loop : loops)
    loop = first_of(loop);
  return loops;
}

struct Middle {
  double x = 0, y = 0, z = 0, ends = 0;
};

}  // namespace

double area_to_close(std::span<const Facet> facets, std::span<const Face> faces,
                     std::span<const BoundaryEdge> boundary_edges) {
  const auto vertex = [&](const BoundaryEdge& edge, std::uint32_t number) {
    const Face& face = faces[edge.face];
    const auto corner = std::find(face.corners.begin(), face.corners.end(), number) - face.corners.begin();
    return facets[face.facet].vertices[static_cast<std::size_t>(corner)];
  };
  const std::vector<std::uint32_t> loops = loops_of(boundary_edges);
  std::vector<Middle> middles(boundary_edges.size());
  for (std::size_t i = 0; i < boundary_edges.size(); ++i) {
    Middle& middle = middles[loops[i]];
    for (const Vertex& v :
         {vertex(boundary_edges[i], boundary_edges[i].from), vertex(boundary_edges[i], boundary_edges[i].to)})
      middle = {middle.x + v.x, middle.y + v.y, middle.z + v.z, middle.ends + 1};
  }
  double area = 0;
  for (std::size_t i = 0; i < boundary_edges.size(); ++i) {
    const Middle& sum = middles[loops[i]];
    const Vertex a = vertex(boundary_edges[i], boundary_edges[i].from),
                 b = vertex(boundary_edges[i], boundary_edges[i].to);
    const double ux = a.x - sum.x / sum.ends, uy = a.y - sum.y / sum.ends, uz = a.z - sum.z / sum.ends;
    const double vx = b.x - sum.x / sum.ends, vy = b.y - sum.y / sum.ends, vz = b.z - sum.z / sum.ends;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    area += std::sqrt(nx * nx + ny * ny + nz * nz) / 2;
  }
  return area;
}

}  // namespace contourd
