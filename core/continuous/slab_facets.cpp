#include "core/continuous/slab_facets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace contourd {
namespace {

// A surface is cut up to a micrometre above its height where a flat face is uneven; twice that is enough.
constexpr double kUnevenMm = 0.002;
// Digits that are lost between a model's coordinates and cells, in cells.
constexpr double kRounding = 0.01;

struct Spot {
  double x, y, z;  // millimetres, or cells and millimetres
};

// A convex polygon: a triangle that planes have cut.
struct Polygon {
  std::array<Spot, 8> spots{};
  std::size_t count = 0;

  void add(const Spot& spot) { spots[count++] = spot; }
  [[nodiscard]] std::span<const Spot> corners() const { return std::span(spots).first(count); }
};

Spot between(const Spot& a, const Spot& b, double part) {
  return {a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part, a.z + (b.z - a.z) * part};
}

// Returns the part of a polygon in which sign * coordinate <= sign * limit.
Polygon clipped(const Polygon& polygon, double Spot::*coordinate, double limit, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Spot &a = polygon.spots[i], &b = polygon.spots[(i + 1) % polygon.count];
    const double from = sign * (a.*coordinate - limit), to = sign * (b.*coordinate - limit);
    if (from <= 0) kept.add(a);
    if ((from < 0 && to > 0) || (from > 0 && to < 0)) kept.add(between(a, b, from / (from - to)));
  }
  return kept;
}

// Columns or rows.
struct CellRange {
  std::int32_t first, last;
};

// Returns the columns or rows, within the border, that hold places from `low` to `high`.
CellRange cells_of(double low, double high, std::int32_t cells) {
  const auto cell_of = [&](double place) {
    return static_cast<std::int32_t>(std::clamp(std::floor(place), 0.0, cells - 1.0));
  };
  return {std::max(cell_of(low), 1), std::min(cell_of(high), cells - 2)};
}

// Lights the cells of a polygon, whose places are in cells, and those up to `margin` beside it.
void light(const Polygon& polygon, double margin, LitCells& cells, StopCheck& stop) {
  const auto [low, high] = std::ranges::minmax(polygon.corners(), {}, &Spot::y);
  const CellRange rows = cells_of(low.y - margin, high.y + margin, cells.rows());
  for (std::int32_t row = rows.first; row <= rows.last; ++row) {
    stop.spend(20);
    const Polygon part = clipped(clipped(polygon, &Spot::y, row - margin, -1), &Spot::y, row + 1 + margin, 1);
    if (part.count == 0) continue;
    const auto [left, right] = std::ranges::minmax(part.corners(), {}, &Spot::x);
    const CellRange columns = cells_of(left.x - margin, right.x + margin, cells.columns());
    for (std::int32_t column = columns.first; column <= columns.last; ++column)
      cells.light(cells.place(column, row));
  }
}

// Returns the part of a facet between two heights of the model.
Polygon part_between(const Facet& facet, double low, double high) {
  Polygon surface;
  for (const Vertex& vertex : facet.vertices)
    surface.add({vertex.x, vertex.y, vertex.z});
  return clipped(clipped(surface, &Spot::z, low, -1), &Spot::z, high, 1);
}

}  // namespace

void light_facets(const PlateModel& model, HeightSpan span, const CellGrid& grid, LitCells& cells,
                  StopCheck& stop) {
  const double low = model.z_at(span.low).count() - kUnevenMm;
  const double high = model.z_at(span.high).count() + kUnevenMm;
  const auto light_facet = [&](const Facet& facet) {
    const Polygon surface = part_between(facet, low, high);
    if (surface.count == 0) return;
    for (const PixelMap& copy : model.copies) {
      Polygon placed = surface;
      for (Spot& spot : std::span(placed.spots).first(placed.count)) {
        const PixelPoint pixel = copy.to_pixels({spot.x, spot.y});
        spot = {pixel.x / grid.side + 1, pixel.y / grid.side + 1, 0};  // the border is a cell wide
      }
      light(placed, grid.outwards + kRounding, cells, stop);
    }
  };
  model.model->for_each_candidate_run(low, high, [&](std::span<const HeightIndex::Candidate> run) {
    for (const HeightIndex::Candidate& candidate : run) {
      stop.spend(1);
      if (candidate.low <= high && candidate.high >= low) light_facet(model.model->facets()[candidate.facet]);
    }
  });
}

}  // namespace contourd
