#include "core/cure/cured_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/cure/pixel_light.hpp"

namespace contourd {
namespace {

// Solid and liquid that are thinner than this do not count: in a file's floats, they could have no thickness.
constexpr Millimeters kThinnest{1e-4};
constexpr float kNone = -1;  // no height above the plate

// A corner's number: 1 for the next column, 2 for the next row, 4 for the upper plane. An edge joins two
// corners that differ in one of these, its axis; it has the number of its first corner, and 8 times the axis.
constexpr std::uint8_t kAxis = 8, kAxes = 3, kCorners = 8;
constexpr std::size_t kEdges = 24;                     // numbers of edges
using Loops = std::vector<std::vector<std::uint8_t>>;  // of edges

std::uint8_t edge_between(std::uint8_t a, std::uint8_t b) {
  const auto axis = static_cast<std::uint8_t>((a ^ b) >> 1U);  // 1, 2, 4 to 0, 1, 2
  return static_cast<std::uint8_t>((a & b) + kAxis * axis);
}

// Adds the facets' sides on one side of a cell, whose corners run counter-clockwise seen from outside: around
// each run of solid corners, with the solid to the right.
void add_sides(std::uint8_t solid, const std::array<std::uint8_t, 4>& corners,
               std::array<std::uint8_t, kEdges>& next) {
  const auto is_solid = [&](std::size_t i) { return ((unsigned{solid} >> corners[i % 4]) & 1U) != 0; };
  for (std::size_t first = 0; first < 4; ++first) {
    if (!is_solid(first) || is_solid(first + 3)) continue;
    std::size_t end = first + 1;
    while (is_solid(end))
      ++end;
    next[edge_between(corners[(first + 3) % 4], corners[first])] =
        edge_between(corners[(end + 3) % 4], corners[end % 4]);
  }
}

// Returns the loops of crossed edges around which the facets of a cell with these solid corners lie.
Loops loops_of(std::uint8_t solid) {
  constexpr std::uint8_t kNoEdge = 0xFF;
  std::array<std::uint8_t, kEdges> next{};
  next.fill(kNoEdge);
  for (unsigned axis = 0; axis < kAxes; ++axis) {
    const unsigned along = 1U << axis, right = 1U << ((axis + 1) % kAxes), up = 1U << ((axis + 2) % kAxes);
    const auto corner = [](unsigned number) { return static_cast<std::uint8_t>(number); };
    add_sides(solid, {corner(along), corner(along | right), corner(along | right | up), corner(along | up)},
              next);
    add_sides(solid, {0, corner(up), corner(right | up), corner(right)}, next);
  }
  Loops loops;
  for (std::uint8_t& first : next) {
    if (first == kNoEdge) continue;
    std::vector<std::uint8_t>& loop = loops.emplace_back();
    for (std::uint8_t* edge = &first; *edge != kNoEdge; edge = &next[loop.back()])
      loop.push_back(std::exchange(*edge, kNoEdge));
  }
  return loops;
}

// Returns the loops by the set of solid corners.
const std::array<Loops, 1U << kCorners>& loops_by_corners() {
  static const auto table = [] {
    std::array<Loops, 1U << kCorners> loops;
    for (unsigned solid = 0; solid < loops.size(); ++solid)
      loops[solid] = loops_of(static_cast<std::uint8_t>(solid));
    return loops;
  }();
  return table;
}

// Returns every step-th pixel, and one before the first and after the last of all.
std::vector<std::int32_t> nodes_on(std::int32_t pixels, std::int32_t step) {
  std::vector<std::int32_t> nodes{-1};
  for (std::int32_t pixel = std::min(step, pixels) / 2; pixel < pixels; pixel += step)
    nodes.push_back(pixel);
  nodes.push_back(pixels);
  return nodes;
}

}  // namespace

CuredSurface::CuredSurface(const DisplayGeometry& display, const PixelWindow& window, std::int32_t step,
                           std::function<void(const Facet&)> sink)
    : display_(display), window_(window), sink_(std::move(sink)) {
  expects(step >= 1 && window.columns >= 1 && window.rows >= 1, "there are lines through pixels");
  const Point zero = on_plate(display, {0, 0}), one = on_plate(display, {1, 1});
  turns_round_ = (one.x > zero.x) != (one.y > zero.y);
  columns_ = nodes_on(window.columns, step);
  rows_ = nodes_on(window.rows, step);
  distance_mm_ = step == 1 ? 0 : step * to_millimeters(display.pixel_pitch).count();
  column_.resize(columns_.size());
  solid_.resize(columns_.size() * rows_.size());
  first_bottom_mm_.resize(solid_.size(), kNone);
  last_top_mm_.resize(solid_.size());
  above_ = {.height_mm = std::numeric_limits<double>::infinity(), .dose = {}, .solid = solid_};
}

void CuredSurface::add_layer(const LayerDose& layer, const CuredLayers& cured, std::span<const float> dose) {
  expects(dose.size() == window_.pixels(), "each pixel has a dose");
  const Millimeters top = cured.solid_top(layer);
  const Millimeters bottom =
      std::max(cured.solid_top({layer.top - layer.thickness, layer.thickness, layer.dose}), Millimeters{});
  if (top - bottom <= 2 * kThinnest) return;  // in the dead zone on the plate
  const Slab slab{layer, cured, std::make_shared<const std::vector<float>>(dose.begin(), dose.end()),
                  top.count(), bottom.count()};
  const double middle_mm = (slab.top_mm + slab.bottom_mm) / 2;
  const bool keeps_ends = distance_mm_ == 0;
  go_down_to(slab.top_mm, slab);
  if (keeps_ends) keep_level(slab.top_mm, slab);
  if (!keeps_ends && above_.height_mm - middle_mm > distance_mm_ - (slab.top_mm - middle_mm)) {
    go_down_to(middle_mm, slab);
    keep_level(middle_mm, slab);
  }
  go_down_to(slab.bottom_mm, slab);
  if (keeps_ends) keep_level(slab.bottom_mm, slab);
}

void CuredSurface::finish() {
  const Level plate{.solid = std::vector<std::uint8_t>(solid_.size())};
  for (std::size_t node = 0; node < solid_.size(); ++node)
    if (solid_[node] != 0 && first_bottom_mm_[node] == kNone) first_bottom_mm_[node] = 0;
  add_cells(plate);
}

// Returns the dose at the layer's top from which on a pixel counts as solid at a height.
double CuredSurface::least_at(double height_mm, const Slab& slab) {
  const Millimeters depth{slab.top_mm - height_mm}, thickness{slab.top_mm - slab.bottom_mm};
  return slab.cured.dose_at_top(std::clamp(depth, kThinnest, thickness - kThinnest));
}

// Finds the nodes that are solid at a height of the layer, and the ends of solids down to there.
void CuredSurface::go_down_to(double height_mm, const Slab& slab) {
  const auto least = static_cast<float>(least_at(height_mm, slab));
  for (std::size_t row = 1; row + 1 < rows_.size(); ++row) {
    const auto first = static_cast<std::size_t>(rows_[row]) * static_cast<std::size_t>(window_.columns);
    for (std::size_t column = 1; column + 1 < columns_.size(); ++column) {
      const std::size_t node = row * columns_.size() + column;
      const float dose = (*slab.dose)[first + static_cast<std::size_t>(columns_[column])];
      const std::uint8_t solid = dose >= least ? 1 : 0;
      if (solid == std::exchange(solid_[node], solid)) continue;
      if (solid != 0) {
        last_top_mm_[node] = static_cast<float>(height_mm);
      } else if (first_bottom_mm_[node] == kNone) {
        first_bottom_mm_[node] = static_cast<float>(
            std::max(slab.top_mm - slab.cured.solid_thickness(slab.layer, dose).count(), height_mm));
      }
    }
  }
}

// Makes the level at the lowest height so far, in the layer, the end of the cells beneath the last one.
// Makes the lowest height so far, in the layer, a level.
void CuredSurface::keep_level(double height_mm, const Slab& slab) {
  Level lower{height_mm, least_at(height_mm, slab), slab.dose, solid_};
  add_cells(lower);
  above_ = std::move(lower);
  std::ranges::fill(first_bottom_mm_, kNone);
}

// Adds the facets between the last level and this one.
void CuredSurface::add_cells(const Level& lower) {
  const std::size_t width = columns_.size();
  for (std::size_t row = 0; row + 1 < rows_.size(); ++row) {
    const std::uint8_t* below = lower.solid.data() + row * width;
    const std::uint8_t* above = above_.solid.data() + row * width;
    for (std::size_t column = 0; column < width; ++column)
      column_[column] = static_cast<std::uint8_t>(below[column] | below[column + width] << 2U |
                                                  above[column] << 4U | above[column + width] << 6U);
    for (std::size_t column = 0; column + 1 < width; ++column) {
      const auto corners = static_cast<std::uint8_t>(column_[column] | column_[column + 1] << 1U);
      if (corners != 0 && corners != 0xFF) add_cell(lower, column, row, corners);
    }
  }
}

void CuredSurface::add_cell(const Level& lower, std::size_t column, std::size_t row, std::uint8_t corners) {
  std::array<Vertex, 12> at{};
  for (const std::vector<std::uint8_t>& loop : loops_by_corners()[corners]) {
    std::ranges::transform(loop, at.begin(),
                           [&](std::uint8_t edge) { return crossing(lower, column, row, edge); });
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
      const Vertex &a = at[0], &b = at[turns_round_ ? i + 1 : i], &c = at[turns_round_ ? i : i + 1];
      // Such a facet is a line, whose sides cancel each other.
      if (a == b || b == c || c == a) continue;
      sink_({{a, b, c}});
    }
  }
}

// Returns the place at which the surface crosses an edge of a cell.
Vertex CuredSurface::crossing(const Level& lower, std::size_t column, std::size_t row,
                              std::uint8_t edge) const {
  column += edge & 1U;
  row += (edge >> 1U) & 1U;
  const Level& level = (edge & 4U) != 0 ? above_ : lower;
  switch (edge / kAxis) {
    case 0:
      return vertex(wall_on(level, columns_, column, rows_[row], true), rows_[row], level.height_mm);
    case 1:
      return vertex(columns_[column], wall_on(level, rows_, row, columns_[column], false), level.height_mm);
    default:
      break;
  }
  const std::size_t node = row * columns_.size() + column;
  return vertex(columns_[column], rows_[row],
                static_cast<double>(above_.solid[node] != 0 ? first_bottom_mm_[node] : last_top_mm_[node]));
}

// Returns the place of the wall between two neighbouring nodes on a line, the one nearest to the solid node.
double CuredSurface::wall_on(const Level& level, const std::vector<std::int32_t>& nodes, std::size_t node,
                             std::int32_t line, bool along_rows) const {
  const std::int32_t length = along_rows ? window_.columns : window_.rows;
  const auto dose = [&](std::int32_t at) {
    if (at < 0 || at >= length) return 0.0;
    const std::int32_t pixel = along_rows ? line * window_.columns + at : at * window_.columns + line;
    return static_cast<double>((*level.dose)[static_cast<std::size_t>(pixel)]);
  };
  const auto is_solid = [&](std::int32_t at) {
    return static_cast<float>(dose(at)) >= static_cast<float>(level.least);
  };
  const bool leaves = is_solid(nodes[node]);
  const std::int32_t outwards = leaves ? 1 : -1;
  std::int32_t at = leaves ? nodes[node] : nodes[node + 1];
  while (is_solid(at + outwards))
    at += outwards;
  const double bright = std::max(dose(at), level.least);  // but for rounding
  constexpr double kBeside = 0.01;                        // keeps walls from lines, where they would meet
  return at +
         outwards * std::clamp(wall_between(bright, dose(at + outwards), level.least), kBeside, 1 - kBeside);
}

Vertex CuredSurface::vertex(double column, double row, double height_mm) const {
  const Point at = on_plate(display_, {window_.column + column + 0.5, window_.row + row + 0.5});
  return {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(height_mm)};
}

}  // namespace contourd
