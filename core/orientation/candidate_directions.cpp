#include "core/orientation/candidate_directions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/model/sine_cosine.hpp"
#include "core/orientation/rated_mesh.hpp"

namespace contourd {
namespace {

constexpr double kCosLeastApart = 0.99863;  // 3 degrees
// The sine of 0.005 degrees, by which a model 100 mm wide rises by 9 um: less than any layer.
constexpr double kLevel = 8.7e-5;
// The cosine of 0.1 degrees: facets of one flat face differ by less, but for rounding.
constexpr double kCosOneFace = 0.9999985;

// Facets whose normals lie in the same cell of this grid, some 2 degrees wide, may belong to one face.
constexpr int kNormalCells = 32;
constexpr std::size_t kCellsAlong = 2 * kNormalCells + 1;

struct NormalCell {
  Direction area{0, 0, 0};     // the sum of the facets' areas
  Direction largest{0, 0, 0};  // the area of the largest facet
  Direction flat{0, 0, 0};     // the sum of the areas of facets that are level with the largest
};

Direction scaled(const Direction& v, double factor) {
  return {v.x * factor, v.y * factor, v.z * factor};
}

void increase(Direction& sum, const Direction& area) {
  sum = {sum.x + area.x, sum.y + area.y, sum.z + area.z};
}

// Returns the cell of an area of this size, which is not 0.
NormalCell& cell_of(std::vector<NormalCell>& cells, const Direction& area, double size) {
  const auto along = [size](double part) {
    return static_cast<std::size_t>(std::lround(part / size * kNormalCells) + kNormalCells);
  };
  return cells[(along(area.x) * kCellsAlong + along(area.y)) * kCellsAlong + along(area.z)];
}

template <typename Visit>
void for_each_area(std::span<const Facet> facets, std::vector<NormalCell>& cells, Visit&& visit) {
  for (const Facet& facet : facets) {
    const Direction area = area_of(facet);
    if (const double size = length_of(area); size > 0) visit(cell_of(cells, area, size), area, size);
  }
}

// Returns the areas of flat faces, largest first. If most of a cell is one flat face, its normal is that of
// the face, undisturbed by other facets nearby. A curved surface is spread over many cells, each with a small
// area.
std::vector<Direction> flat_faces(std::span<const Facet> facets) {
  std::vector<NormalCell> cells(kCellsAlong * kCellsAlong * kCellsAlong);
  for_each_area(facets, cells, [](NormalCell& cell, const Direction& area, double size) {
    increase(cell.area, area);
    if (size > length_of(cell.largest)) cell.largest = area;
  });
  for_each_area(facets, cells, [](NormalCell& cell, const Direction& area, double size) {
    if (dot(area, cell.largest) > kCosOneFace * size * length_of(cell.largest)) increase(cell.flat, area);
  });
  std::vector<Direction> faces;
  for (const NormalCell& cell : cells) {
    const double size = length_of(cell.area), flat = length_of(cell.flat);
    if (size > 0) faces.push_back(flat > size / 2 ? scaled(cell.flat, size / flat) : cell.area);
  }
  std::ranges::stable_sort(faces, std::ranges::greater{}, length_of);
  return faces;
}

bool is_apart(std::span<const Direction> directions, const Direction& candidate) {
  return std::ranges::none_of(directions,
                              [&](const Direction& other) { return dot(candidate, other) > kCosLeastApart; });
}

void add(std::vector<Direction>& directions, const Direction& candidate) {
  if (is_apart(directions, candidate)) directions.push_back(candidate);
}

void add_faces(std::vector<Direction>& directions, std::span<const Facet> facets) {
  for (const Direction& area : flat_faces(facets)) {
    if (directions.size() > kMostFaceDirections) break;
    const Direction up = scaled(area, -1 / length_of(area));
    const bool as_drawn = up.z > 0 && std::hypot(up.x, up.y) < kLevel;
    if (!as_drawn && is_apart(std::span(directions).subspan(1), up)) directions.push_back(up);
  }
}

// Adds directions on a spiral from pole to pole, each the golden angle further round than the previous one.
void add_spread(std::vector<Direction>& directions) {
  constexpr double kGoldenAngleDeg = 137.50776405003785;
  for (std::size_t i = 0; i < kSpreadDirections; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(kSpreadDirections);
    const double across = std::sqrt(1 - z * z);
    const auto [sine, cosine] = sine_cosine(std::fmod(static_cast<double>(i) * kGoldenAngleDeg, 360.0));
    add(directions, {across * cosine, across * sine, z});
  }
}

}  // namespace

std::vector<Direction> face_directions(std::span<const Facet> facets) {
  std::vector<Direction> directions{kAsDrawn};
  add_faces(directions, facets);
  directions.erase(directions.begin());
  return directions;
}

std::vector<Direction> candidate_directions(std::span<const Facet> facets) {
  std::vector<Direction> directions{kAsDrawn};
  add_faces(directions, facets);
  for (const Direction& axis : {Direction{0, 0, -1}, Direction{1, 0, 0}, Direction{-1, 0, 0},
                                Direction{0, 1, 0}, Direction{0, -1, 0}})
    add(directions, axis);
  add_spread(directions);
  return directions;
}

}  // namespace contourd
