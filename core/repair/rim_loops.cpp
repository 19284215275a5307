#include "core/repair/rim_loops.hpp"

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
  std::uint32_t rim;
};

// By rim: the number of the first rim of its loop.
std::vector<std::uint32_t> loops_of(std::span<const Rim> rims) {
  std::vector<End> ends;
  for (std::uint32_t i = 0; i < rims.size(); ++i) {
    ends.push_back({rims[i].from, i});
    ends.push_back({rims[i].to, i});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.rim < b.rim;
  });
  std::vector<std::uint32_t> loops(rims.size());
  std::iota(loops.begin(), loops.end(), 0U);
  const auto first_of = [&loops](std::uint32_t rim) {
    while (loops[rim] != rim)
      rim = loops[rim] = loops[loops[rim]];
    return rim;
  };
  for (std::size_t i = 1; i < ends.size(); ++i) {
    if (ends[i].vertex != ends[i - 1].vertex) continue;
    const std::uint32_t a = first_of(ends[i - 1].rim), b = first_of(ends[i].rim);
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

double area_to_close(std::span<const Facet> facets, std::span<const Face> faces, std::span<const Rim> rims) {
  const auto vertex = [&](const Rim& rim, std::uint32_t number) {
    const Face& face = faces[rim.face];
    const auto corner = std::find(face.corners.begin(), face.corners.end(), number) - face.corners.begin();
    return facets[face.facet].vertices[static_cast<std::size_t>(corner)];
  };
  const std::vector<std::uint32_t> loops = loops_of(rims);
  std::vector<Middle> middles(rims.size());
  for (std::size_t i = 0; i < rims.size(); ++i) {
    Middle& middle = middles[loops[i]];
    for (const Vertex& v : {vertex(rims[i], rims[i].from), vertex(rims[i], rims[i].to)})
      middle = {middle.x + v.x, middle.y + v.y, middle.z + v.z, middle.ends + 1};
  }
  double area = 0;
  for (std::size_t i = 0; i < rims.size(); ++i) {
    const Middle& sum = middles[loops[i]];
    const Vertex a = vertex(rims[i], rims[i].from), b = vertex(rims[i], rims[i].to);
    const double ux = a.x - sum.x / sum.ends, uy = a.y - sum.y / sum.ends, uz = a.z - sum.z / sum.ends;
    const double vx = b.x - sum.x / sum.ends, vy = b.y - sum.y / sum.ends, vz = b.z - sum.z / sum.ends;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    area += std::sqrt(nx * nx + ny * ny + nz * nz) / 2;
  }
  return area;
}

}  // namespace contourd
