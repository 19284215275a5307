#include "core/orientation/rated_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/contract/expects.hpp"
#include "core/geometry/point_hash.hpp"

namespace contourd {
namespace {

constexpr double kCosBeside = 0.70710678118654752;  // 45 degrees

bool lies_in(const KeepCleanBox& box, const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const auto between = [](double least, double sum, double most) {
    return 3 * least <= sum && sum <= 3 * most;
  };
  return between(box.least.x, double{a.x} + b.x + c.x, box.most.x) &&
         between(box.least.y, double{a.y} + b.y + c.y, box.most.y) &&
         between(box.least.z, double{a.z} + b.z + c.z, box.most.z);
}

bool is_kept(std::span<const KeepClean> keep_clean, const Facet& facet, const Direction& area) {
  return std::ranges::any_of(keep_clean, [&](const KeepClean& each) {
    if (const auto* const box = std::get_if<KeepCleanBox>(&each)) return lies_in(*box, facet);
    const auto& direction = std::get<Direction>(each);
    return dot(direction, area) > kCosBeside * length_of(direction) * length_of(area);
  });
}

}  // namespace

FacetSample sample_of(std::span<const Facet> facets, std::span<const double> exposed, std::size_t most) {
  expects(most > 0, "the sample may hold at least one facet");
  const auto area_that_counts = [&](std::size_t f) {
    return length_of(area_of(facets[f])) * (exposed.empty() ? 1 : exposed[f]);
  };
  double surface = 0;
  for (std::size_t f = 0; f < facets.size(); ++f)
    surface += area_that_counts(f);
  FacetSample sample;
  // Walking adds the areas in the same order: but for rounding, the last part is full at the end.
  const double part = surface / static_cast<double>(most);
  if (!(part > 0)) return sample;
  double walked = 0, full = 0;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    walked += area_that_counts(f);
    const double parts = std::floor(walked / part);
    if (!(parts > full)) continue;
    sample.facets.push_back(facets[f]);
    sample.weights.push_back((parts - full) * part / length_of(area_of(facets[f])));
    full = parts;
  }
  return sample;
}

RatedMesh::RatedMesh(const Making& making) {
  expects(making.weights.empty() || making.weights.size() == making.facets.size(),
          "there is a weight for each facet, or for none");
  expects(making.cell_mm > 0, "cells have a size");
  const std::vector<Corners> corners = number_vertices(making.facets);
  sides_.reserve(corners.size());
  for (std::size_t f = 0; f < corners.size(); ++f) {
    const Facet& facet = making.facets[f];
    for (std::size_t i = 0; i < 3; ++i)  // numbers are given in the order in which vertices come
      if (corners[f][i] == vertices_.size()) vertices_.push_back(facet.vertices[i]);
    const Direction area = area_of(facet);
    const double factor = making.weights.empty() ? 1 : making.weights[f];
    const Direction outwards{area.x * factor, area.y * factor, area.z * factor};
    sides_.push_back({corners[f], static_cast<float>(outwards.x), static_cast<float>(outwards.y),
                      static_cast<float>(outwards.z), static_cast<float>(length_of(outwards)),
                      is_kept(making.keep_clean, facet, outwards), factor == 0});
  }
  number_cells(making.cell_mm);
}

void RatedMesh::number_cells(double cell_mm) {
  // Cell coordinates repeat after 2^21 cells: at worst, two places far from each other count as one.
  const auto along = [cell_mm](float coordinate) {
    const double cell = std::floor(coordinate / cell_mm);
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::clamp(cell, -1e15, 1e15))) & 0x1FFFFFU;
  };
  struct Mixed {
    std::size_t operator()(std::uint64_t key) const { return mixed(key, 1); }
  };
  std::unordered_map<std::uint64_t, std::uint32_t, Mixed> numbers;
  cells_.reserve(vertices_.size());
  for (const Vertex& v : vertices_) {
    const std::uint64_t key = along(v.x) << 42U | along(v.y) << 21U | along(v.z);
    const auto number = static_cast<std::uint32_t>(numbers.size());
    cells_.push_back(numbers.try_emplace(key, number).first->second);
  }
  cell_count_ = static_cast<std::uint32_t>(numbers.size());
}

}  // namespace contourd
