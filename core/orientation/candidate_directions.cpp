#include "core/orientation/candidate_directions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/model/sine_cosine.hpp"
#include "core/orientation/facet_area.hpp"

namespace contourd {
namespace {

constexpr double kCosLeastApart = 0.99863;  // 3 degrees

// Facets whose normals lie in the same cell of this grid, some 2 degrees wide, are taken for one face.
constexpr int kNormalCells = 32;
constexpr std::size_t kCellsAlong = 2 * kNormalCells + 1;

void add(std::vector<Direction>& directions, const Direction& candidate) {
  const bool is_new = std::ranges::none_of(
      directions, [&](const Direction& other) { return dot(candidate, other) > kCosLeastApart; });
  if (is_new) directions.push_back(candidate);
}

std::size_t cell_of(const Direction& normal) {
  const auto along = [](double part) {
    return static_cast<std::size_t>(std::lround(part * kNormalCells) + kNormalCells);
  };
  return (along(normal.x) * kCellsAlong + along(normal.y)) * kCellsAlong + along(normal.z);
}

Direction scaled(const Direction& v, double factor) {
  return {v.x * factor, v.y * factor, v.z * factor};
}

// Returns the areas of flat faces, largest first. A curved surface is spread over many cells, each with a
// small area.
std::vector<Direction> flat_faces(std::span<const Facet> facets) {
  std::vector<Direction> cells(kCellsAlong * kCellsAlong * kCellsAlong, Direction{0, 0, 0});
  for (const Facet& facet : facets) {
    const Direction area = area_of(facet);
    const double size = length_of(area);
    if (!(size > 0)) continue;
    Direction& sum = cells[cell_of(scaled(area, 1 / size))];
    sum = {sum.x + area.x, sum.y + area.y, sum.z + area.z};
  }
  std::erase_if(cells, [](const Direction& area) { return !(length_of(area) > 0); });
  std::ranges::stable_sort(cells, std::ranges::greater{}, length_of);
  return cells;
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

std::vector<Direction> candidate_directions(std::span<const Facet> facets) {
  std::vector<Direction> directions{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (const Direction& area : flat_faces(facets)) {
    if (directions.size() == 6 + kMostFaceDirections) break;
    add(directions, scaled(area, -1 / length_of(area)));
  }
  add_spread(directions);
  return directions;
}

}  // namespace contourd
