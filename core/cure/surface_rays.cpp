#include "core/cure/surface_rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/cure/ray_sort.hpp"

namespace contourd {
namespace {

using Coordinates = std::array<double, 3>;

// The lattice on which lines along an axis stand: `across` is the finer of the two other axes, numbered
// first.
struct Lattice {
  std::size_t along, across, up;  // axes as indices of Coordinates
  std::vector<double> across_at, up_at;
};

std::vector<double> middles(std::int32_t first, std::int32_t count) {
  std::vector<double> at(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < at.size(); ++i)
    at[i] = first + static_cast<double>(i) + 0.5;
  return at;
}

Lattice lattice_of(const Rays& rays) {
  const std::vector<double> columns = middles(rays.window.column, rays.window.columns);
  const std::vector<double> rows = middles(rays.window.row, rays.window.rows);
  switch (rays.axis) {
    case RayAxis::X:
      return {0, 1, 2, rows, rays.heights_mm};
    case RayAxis::Y:
      return {1, 0, 2, columns, rays.heights_mm};
    case RayAxis::Z:
      break;
  }
  return {2, 0, 1, columns, rows};
}

// Returns where a side crosses a line of the lattice, computed from its lower end whatever its direction, so
// that both facets of the side find the same place.
double across_on(Coordinates a, Coordinates b, double up_at, const Lattice& lattice) {
  if (std::tie(a[lattice.up], a[lattice.across]) > std::tie(b[lattice.up], b[lattice.across]))
    std::swap(a, b);
  const double part = (up_at - a[lattice.up]) / (b[lattice.up] - a[lattice.up]);
  return a[lattice.across] + part * (b[lattice.across] - a[lattice.across]);
}

// Returns the first of these rising positions that is not below the least. Most positions have equal
// distances, so that a guess is right.
std::size_t first_from(const std::vector<double>& at, double least) {
  if (at.size() > 1) {
    const auto count = static_cast<double>(at.size());
    const double guess = std::ceil((least - at.front()) * ((count - 1) / (at.back() - at.front())));
    const auto first = static_cast<std::size_t>(guess > 0 ? std::min(guess, count) : 0);
    if ((first == 0 || at[first - 1] < least) && (first == at.size() || at[first] >= least)) return first;
  }
  return static_cast<std::size_t>(std::ranges::lower_bound(at, least) - at.begin());
}

class Crossings {
 public:
  explicit Crossings(Lattice lattice) : lattice_(std::move(lattice)) {}
  // Keeps crossings within the range only.
  Crossings(Lattice lattice, const RayRange& range)
      : lattice_(std::move(lattice)), above_(range.above_mm), up_to_(range.up_to_mm) {}

  // `normal` points outwards, in millimetres.
  void add(const std::array<Coordinates, 3>& corners, const Coordinates& normal, const Coordinates& plane) {
    const auto [low, high] =
        std::minmax({corners[0][lattice_.up], corners[1][lattice_.up], corners[2][lattice_.up]});
    std::size_t up = first_from(lattice_.up_at, low);
    if (up == lattice_.up_at.size() || lattice_.up_at[up] >= high) return;
    const double size = std::hypot(normal[0], normal[1], normal[2]);
    if (!(size > 0) || plane[lattice_.along] == 0) return;
    const auto steepness = static_cast<float>(normal[lattice_.along] / size);
    for (; up < lattice_.up_at.size() && lattice_.up_at[up] < high; ++up)
      add_row(corners, plane, up, steepness);
  }

  [[nodiscard]] std::size_t count() const { return crossings_.size(); }
  [[nodiscard]] std::vector<RayCrossing> take() { return std::move(crossings_); }

 private:
  void add_row(const std::array<Coordinates, 3>& corners, const Coordinates& plane, std::size_t up,
               float steepness) {
    const double up_at = lattice_.up_at[up];
    std::array<double, 3> ends{};
    std::size_t count = 0;
    for (std::size_t side = 0; side < 3; ++side) {
      const Coordinates &a = corners[side], &b = corners[(side + 1) % 3];
      if ((a[lattice_.up] <= up_at) != (b[lattice_.up] <= up_at))
        ends[count++] = across_on(a, b, up_at, lattice_);
    }
    if (count != 2) return;
    const auto [from, to] = std::minmax(ends[0], ends[1]);
    const auto [lowest, highest] =
        std::minmax({corners[0][lattice_.along], corners[1][lattice_.along], corners[2][lattice_.along]});
    const double slope = -plane[lattice_.across] / plane[lattice_.along];
    const double at_zero = corners[0][lattice_.along] - slope * corners[0][lattice_.across] -
                           plane[lattice_.up] / plane[lattice_.along] * (up_at - corners[0][lattice_.up]);
    for (std::size_t across = first_from(lattice_.across_at, std::max(from, first_across(at_zero, slope)));
         across < lattice_.across_at.size() && lattice_.across_at[across] < to; ++across) {
      const double at = std::clamp(at_zero + slope * lattice_.across_at[across], lowest, highest);
      if (slope != 0 && (slope > 0 ? at > up_to_ : at <= above_)) return;
      if (at > above_ && at <= up_to_)
        crossings_.push_back({static_cast<std::uint32_t>(across + up * lattice_.across_at.size()),
                              static_cast<float>(at), steepness});
    }
  }

  // Returns a place before which the line through `at_zero` is beyond the range that is kept.
  [[nodiscard]] double first_across(double at_zero, double slope) const {
    constexpr double kRounding = 1e-6;  // pixels
    if (slope == 0) return -std::numeric_limits<double>::infinity();
    return ((slope > 0 ? above_ : up_to_) - at_zero) / slope - kRounding;
  }

  Lattice lattice_;
  double above_ = -std::numeric_limits<double>::infinity();
  double up_to_ = std::numeric_limits<double>::infinity();
  std::vector<RayCrossing> crossings_;
};

Coordinates cross(const Coordinates& a, const Coordinates& b, const Coordinates& c) {
  const double ux = b[0] - a[0], uy = b[1] - a[1], uz = b[2] - a[2];
  const double vx = c[0] - a[0], vy = c[1] - a[1], vz = c[2] - a[2];
  return {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
}

Coordinates normal_of(const Facet& facet) {
  const auto at = [&facet](std::size_t corner) {
    const Vertex& vertex = facet.vertices[corner];
    return Coordinates{vertex.x, vertex.y, vertex.z};
  };
  return cross(at(0), at(1), at(2));
}

// A model's place on the display.
class Copy {
 public:
  Copy(const PlateModel& model, const PixelMap& map)
      : map_(map), lift_(model.elevation.lift(model.model->bounds()).count()) {
    const PixelPoint origin = map.to_pixels({0, 0}), one = map.to_pixels({1, 1});
    right_ = one.x > origin.x ? 1 : -1;
    down_ = one.y > origin.y ? 1 : -1;
  }

  void cross(const Facet& facet, const Coordinates& normal, Crossings& crossings) const {
    std::array<Coordinates, 3> on_display{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vertex& vertex = facet.vertices[corner];
      const PixelPoint pixel = map_.to_pixels({vertex.x, vertex.y});
      on_display[corner] = {pixel.x, pixel.y, vertex.z + lift_};
    }
    crossings.add(on_display, {normal[0] * right_, normal[1] * down_, normal[2]},
                  contourd::cross(on_display[0], on_display[1], on_display[2]));
  }

 private:
  PixelMap map_;
  double lift_, right_ = 1, down_ = 1;
};

}  // namespace

PixelWindow window_of(std::span<const PlateModel> models, const DisplayGeometry& display,
                      std::int32_t margin) {
  const double width = display.width.count(), height = display.height.count();
  double left = width, top = height, right = 0, bottom = 0;
  for (const PlateModel& model : models) {
    const Bounds& bounds = model.model->bounds();
    for (const PixelMap& map : model.copies) {
      const PixelPoint a = map.to_pixels({bounds.min_x, bounds.min_y});
      const PixelPoint b = map.to_pixels({bounds.max_x, bounds.max_y});
      left = std::min({left, a.x, b.x});
      right = std::max({right, a.x, b.x});
      top = std::min({top, a.y, b.y});
      bottom = std::max({bottom, a.y, b.y});
    }
  }
  const auto pixel = [margin](double at, int outwards, double size) {
    return static_cast<std::int32_t>(std::clamp(std::floor(at) + outwards * margin, 0.0, size));
  };
  const PixelWindow window{pixel(left, -1, width), pixel(top, -1, height), 0, 0};
  const std::int32_t end_column = pixel(right + 1, 1, width), end_row = pixel(bottom + 1, 1, height);
  if (end_column <= window.column || end_row <= window.row) return {0, 0, 1, 1};
  return {window.column, window.row, end_column - window.column, end_row - window.row};
}

std::vector<RayCrossing> cross_surface(std::span<const PlateModel> models, const Rays& rays,
                                       StopCheck& check) {
  Crossings crossings(lattice_of(rays));
  for (const PlateModel& model : models) {
    expects(model.model != nullptr, "no null pointers");
    for (const PixelMap& map : model.copies) {
      const Copy copy(model, map);
      for (const Facet& facet : model.model->facets()) {
        const std::size_t before = crossings.count();
        copy.cross(facet, normal_of(facet), crossings);
        check.spend(10 + crossings.count() - before);
      }
    }
  }
  return crossings.take();
}

std::vector<RayCrossing> entries_between(std::span<const PlateModel> models, const PixelWindow& window,
                                         const RayRange& range, MaskBudget& budget) {
  Crossings crossings(lattice_of({.axis = RayAxis::Z, .window = window}), range);
  for (const PlateModel& model : models) {
    expects(model.model != nullptr, "no null pointers");
    const double lift = model.elevation.lift(model.model->bounds()).count();
    const double above = range.above_mm - lift, up_to = range.up_to_mm - lift;
    std::vector<Copy> copies;
    for (const PixelMap& map : model.copies)
      copies.emplace_back(model, map);
    const std::span<const Facet> facets = model.model->facets();
    const auto in_range = [&](const HeightIndex::Candidate& candidate) {
      return static_cast<double>(candidate.high) > above && static_cast<double>(candidate.low) <= up_to;
    };
    const auto add = [&](const Facet& facet) {
      const Coordinates normal = normal_of(facet);
      if (!budget.spend(1) || !(normal[2] < 0)) return;
      const std::size_t before = crossings.count();
      for (const Copy& copy : copies) {
        if (!budget.spend(1) || crossings.count() >= window.pixels()) return;
        copy.cross(facet, normal, crossings);
      }
      (void)budget.spend(crossings.count() - before);
    };
    model.model->for_each_candidate_run(above, up_to, [&](std::span<const HeightIndex::Candidate> run) {
      constexpr std::size_t kAhead = 16;  // facets are in the file's order, far from each other
      for (std::size_t i = 0; i < run.size(); ++i) {
        if (i + kAhead < run.size()) __builtin_prefetch(&facets[run[i + kAhead].facet]);
        if (in_range(run[i])) add(facets[run[i].facet]);
      }
    });
  }
  return crossings.take();
}

std::vector<RayStretch> stretches_within(std::vector<RayCrossing> crossings, StopCheck& check) {
  const auto is_before = [](const RayCrossing& a, const RayCrossing& b) {
    return std::tie(a.at, a.steepness) < std::tie(b.at, b.steepness);
  };
  sort_by_ray(crossings, &RayCrossing::ray, is_before, check);
  std::vector<RayStretch> stretches;
  int inside = 0;
  RayCrossing from{};
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const RayCrossing& crossing = crossings[i];
    if (i == 0 || crossing.ray != crossings[i - 1].ray) inside = 0;
    const int before = inside;
    inside += crossing.steepness < 0 ? 1 : -1;
    if (before <= 0 && inside > 0) from = crossing;
    if (before > 0 && inside <= 0 && crossing.at > from.at) {
      // Surfaces that touch end no stretch.
      if (!stretches.empty() && stretches.back().ray == crossing.ray && stretches.back().to.at >= from.at) {
        stretches.back().to = crossing;
      } else {
        stretches.push_back({crossing.ray, from, crossing});
      }
    }
  }
  return stretches;
}

}  // namespace contourd
