#include "core/support/support_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/model/placement.hpp"
#include "core/model/sine_cosine.hpp"

namespace contourd {
namespace {

constexpr int kFewestSides = 12, kMostSides = 96;

// The middle of a chord is off its circle by slightly less than radius (pi / sides)^2 / 2. A facet between
// two rings of a ball may be off by as much in both directions.
int sides_for(double radius_mm) {
  constexpr double kPi = 3.14159265358979323846;
  const double needed = std::min(kPi * std::sqrt(radius_mm / kMeshErrorMm), double{kMostSides});
  return std::clamp((static_cast<int>(needed) + 4) / 4 * 4, kFewestSides, kMostSides);
}

// Unit vectors: `axis` points along the axis, `second` is a quarter turn from `first` as seen from the end of
// the axis.
struct Frame {
  Direction first, second, axis;
};

Frame upright_frame() {
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

Frame frame_of(const Frustum& frustum) {
  const double x = frustum.upper.x - frustum.lower.x, y = frustum.upper.y - frustum.lower.y;
  const double z = frustum.upper.z - frustum.lower.z;
  const double level = std::sqrt(x * x + y * y);
  if (level == 0) return upright_frame();
  const double length = std::sqrt(level * level + z * z);
  const Direction axis{x / length, y / length, z / length}, first{-y / level, x / level, 0};
  const Direction second{axis.y * first.z - axis.z * first.y, axis.z * first.x - axis.x * first.z,
                         axis.x * first.y - axis.y * first.x};
  return {first, second, axis};
}

// A circle around an axis; a single point if its radius is 0.
struct Ring {
  PlatePoint middle;
  double radius_mm;
};

std::vector<Vertex> corners_of(const Ring& ring, const Frame& frame, int sides) {
  std::vector<Vertex> corners;
  for (int i = 0; i < sides; ++i) {
    const SineCosine turn = sine_cosine(360.0 * i / sides);
    const double a = ring.radius_mm * turn.cosine, b = ring.radius_mm * turn.sine;
    corners.push_back({static_cast<float>(ring.middle.x + a * frame.first.x + b * frame.second.x),
                       static_cast<float>(ring.middle.y + a * frame.first.y + b * frame.second.y),
                       static_cast<float>(ring.middle.z + a * frame.first.z + b * frame.second.z)});
  }
  return corners;
}

// Adds the surface through the rings, closed by a disc at each end unless that end is a point.
void add_rings(std::span<const Ring> rings, const Frame& frame, int sides, std::vector<Facet>& facets) {
  const auto count = static_cast<std::size_t>(sides);
  std::vector<Vertex> below = corners_of(rings.front(), frame, sides);
  for (std::size_t i = 1; rings.front().radius_mm > 0 && i + 1 < count; ++i)
    facets.push_back({{below[0], below[i + 1], below[i]}});
  for (std::size_t ring = 1; ring < rings.size(); ++ring) {
    std::vector<Vertex> above = corners_of(rings[ring], frame, sides);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = (i + 1) % count;
      if (rings[ring - 1].radius_mm > 0) facets.push_back({{below[i], below[next], above[next]}});
      if (rings[ring].radius_mm > 0) facets.push_back({{below[i], above[next], above[i]}});
    }
    below = std::move(above);
  }
  for (std::size_t i = 1; rings.back().radius_mm > 0 && i + 1 < count; ++i)
    facets.push_back({{below[0], below[i], below[i + 1]}});
}

void add_mesh(const Frustum& frustum, std::vector<Facet>& facets) {
  const Ring rings[]{{frustum.lower, frustum.lower_radius_mm}, {frustum.upper, frustum.upper_radius_mm}};
  add_rings(rings, frame_of(frustum), sides_for(std::max(rings[0].radius_mm, rings[1].radius_mm)), facets);
}

void add_mesh(const Ball& ball, std::vector<Facet>& facets) {
  if (ball.radius_mm == 0) return;
  const int sides = sides_for(ball.radius_mm), bands = sides / 2;
  std::vector<Ring> rings;
  for (int i = 0; i <= bands; ++i) {
    const SineCosine turn = sine_cosine(180.0 * i / bands - 90.0);
    const PlatePoint middle{ball.center.x, ball.center.y, ball.center.z + ball.radius_mm * turn.sine};
    rings.push_back({middle, i == 0 || i == bands ? 0 : ball.radius_mm * turn.cosine});
  }
  add_rings(rings, upright_frame(), sides, facets);
}

// Returns where the edge passes the plate. It is interpolated from the lower to the upper end, so that the
// facets on both sides of the edge get the same point.
Vertex on_the_plate(const Vertex& from, const Vertex& to) {
  const auto& [lower, upper] =
      std::minmax(from, to, [](const Vertex& a, const Vertex& b) { return a.z < b.z; });
  const double part = -double{lower.z} / (double{upper.z} - double{lower.z});
  return {static_cast<float>(lower.x + part * (double{upper.x} - double{lower.x})),
          static_cast<float>(lower.y + part * (double{upper.y} - double{lower.y})), 0};
}

// Appends the part of the facet above the plate. Returns the edge along which the plate cuts the facet.
std::optional<std::array<Vertex, 2>> add_above_plate(const Facet& facet, std::vector<Facet>& facets) {
  std::vector<Vertex> corners;
  std::vector<Vertex> cuts;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vertex &from = facet.vertices[i], &to = facet.vertices[(i + 1) % 3];
    if (from.z >= 0) corners.push_back(from);
    if ((from.z >= 0) == (to.z >= 0)) continue;
    corners.push_back(on_the_plate(from, to));
    cuts.push_back(corners.back());
    // The edge leads from where the outline goes below the plate to where it comes up again.
    if (cuts.size() == 2 && from.z >= 0) std::swap(cuts[0], cuts[1]);
  }
  for (std::size_t i = 2; i < corners.size(); ++i)
    facets.push_back({{corners[0], corners[i - 1], corners[i]}});
  if (cuts.empty()) return std::nullopt;
  return std::array{cuts[0], cuts[1]};
}

// Returns the part of a convex mesh above the plate, closed by a face on the plate.
std::vector<Facet> above_plate(const std::vector<Facet>& mesh) {
  std::vector<Facet> facets;
  std::optional<Vertex> corner;
  for (const Facet& facet : mesh) {
    const auto cut = add_above_plate(facet, facets);
    if (!cut) continue;
    if (!corner) corner = (*cut)[0];
    facets.push_back({{*corner, (*cut)[1], (*cut)[0]}});
  }
  std::erase_if(facets, [](const Facet& facet) {
    const auto& [a, b, c] = facet.vertices;
    return a == b || b == c || c == a;
  });
  return facets;
}

bool reaches_below_plate(const std::vector<Facet>& mesh) {
  return std::ranges::any_of(mesh, [](const Facet& facet) {
    return std::ranges::any_of(facet.vertices, [](const Vertex& vertex) { return vertex.z < 0; });
  });
}

}  // namespace

std::vector<Facet> support_mesh(std::span<const SupportPrimitive> primitives) {
  std::vector<Facet> facets;
  for (const SupportPrimitive& primitive : primitives) {
    std::vector<Facet> mesh;
    std::visit([&mesh](const auto& each) { add_mesh(each, mesh); }, primitive);
    if (reaches_below_plate(mesh)) mesh = above_plate(mesh);
    facets.insert(facets.end(), mesh.begin(), mesh.end());
  }
  return facets;
}

}  // namespace contourd
