#include "core/overhangs/surface_probe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

struct Vector {
  double x = 0, y = 0, z = 0;
};

Vector between(const PlatePoint& from, const PlatePoint& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

// Twice the facet's area long, outwards.
Vector normal_of(const PlatePoint& a, const PlatePoint& b, const PlatePoint& c) {
  const Vector u = between(a, b), v = between(a, c);
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

// Where the facet lies over a point of the plate, or at its edges nearest to it.
struct Nearest {
  PlatePoint point;
  double squared_distance;  // seen from above
};

Nearest nearest_on_side(const PlatePoint& from, const PlatePoint& to, Point place) {
  const double x = to.x - from.x, y = to.y - from.y;
  const double squared_length = x * x + y * y;
  const double along = (place.x - from.x) * x + (place.y - from.y) * y;
  const double part = squared_length > 0 ? std::clamp(along / squared_length, 0.0, 1.0) : 0.0;
  const PlatePoint point{from.x + part * x, from.y + part * y, from.z + part * (to.z - from.z)};
  const double dx = point.x - place.x, dy = point.y - place.y;
  return {point, dx * dx + dy * dy};
}

Nearest nearest_on(const PlatePoint& a, const PlatePoint& b, const PlatePoint& c, Point place) {
  const auto turn = [place](const PlatePoint& from, const PlatePoint& to) {
    return (to.x - from.x) * (place.y - from.y) - (to.y - from.y) * (place.x - from.x);
  };
  const double over_c = turn(a, b), over_a = turn(b, c), over_b = turn(c, a);
  const double all = over_a + over_b + over_c;
  const bool over =
      (over_a >= 0 && over_b >= 0 && over_c >= 0) || (over_a <= 0 && over_b <= 0 && over_c <= 0);
  if (over && all != 0) return {{place.x, place.y, (over_a * a.z + over_b * b.z + over_c * c.z) / all}, 0};
  const std::array<Nearest, 3> sides{nearest_on_side(a, b, place), nearest_on_side(b, c, place),
                                     nearest_on_side(c, a, place)};
  return *std::ranges::min_element(sides, {}, &Nearest::squared_distance);
}

// A box of the plate in a model's own coordinates.
struct ModelBox {
  PlatePoint low, high;

  // `origin` and `ones` are where the model's (0, 0, 0) and (1, 1, 0) are on the plate.
  ModelBox(const PlatePoint& from, const PlatePoint& to, const PlatePoint& origin, const PlatePoint& ones) {
    const auto ordered = [](double a, double b, double zero, double one, double& least, double& most) {
      const double u = (a - zero) / (one - zero), v = (b - zero) / (one - zero);
      least = std::min(u, v);
      most = std::max(u, v);
    };
    ordered(from.x, to.x, origin.x, ones.x, low.x, high.x);
    ordered(from.y, to.y, origin.y, ones.y, low.y, high.y);
    low.z = from.z - origin.z;
    high.z = to.z - origin.z;
  }
  [[nodiscard]] bool meets(const std::array<Vertex, 3>& v) const {
    return std::max({v[0].x, v[1].x, v[2].x}) >= low.x && std::min({v[0].x, v[1].x, v[2].x}) <= high.x &&
           std::max({v[0].y, v[1].y, v[2].y}) >= low.y && std::min({v[0].y, v[1].y, v[2].y}) <= high.y;
  }
};

// What is behind the surface there, all facets near taken together.
Direction outward_of(const Vector& sum) {
  const Vector down{sum.x, sum.y, std::min(sum.z, 0.0)};
  const double length = std::sqrt(down.x * down.x + down.y * down.y + down.z * down.z);
  if (!(length > 0)) return {0, 0, -1};
  return {down.x / length, down.y / length, down.z / length};
}

}  // namespace

SurfaceProbe::SurfaceProbe(std::span<const PlateModel> models, const DisplayGeometry& display)
    : models_(models), display_(display) {
  expects(std::ranges::all_of(models_, [](const PlateModel& each) { return each.model != nullptr; }),
          "every model is there");
}

// Visits those whose bounds meet the box, seen from above and by height.
template <typename Visit>
void SurfaceProbe::for_each_facet(const PlatePoint& low, const PlatePoint& high, Visit&& visit) const {
  for (const PlateModel& model : models_) {
    const double lift_mm = model.elevation.lift(model.model->bounds()).count();
    for (const PixelMap& copy : model.copies) {
      const auto placed = [&](const Vertex& v) {
        const Point at = on_plate(display_, copy.to_pixels({v.x, v.y}));
        return PlatePoint{at.x, at.y, v.z + lift_mm};
      };
      const ModelBox box(low, high, placed({0, 0, 0}), placed({1, 1, 0}));
      model.model->for_each_candidate_run(box.low.z, box.high.z,
                                          [&](std::span<const HeightIndex::Candidate> run) {
                                            for (const HeightIndex::Candidate& candidate : run) {
                                              if (candidate.low > box.high.z || candidate.high < box.low.z)
                                                continue;
                                              const auto& v = model.model->facets()[candidate.facet].vertices;
                                              if (box.meets(v))
                                                visit(PlacedFacet{placed(v[0]), placed(v[1]), placed(v[2])});
                                            }
                                          });
    }
  }
}

std::optional<SurfaceProbe::Surface> SurfaceProbe::beneath(Point place, const Range& range,
                                                           double reach_mm) const {
  // Right over the place comes first, then what is nearest to it.
  double best_distance = std::numeric_limits<double>::infinity();
  std::optional<double> z_mm;
  Vector sum;
  const PlatePoint low{place.x - reach_mm, place.y - reach_mm, range.low_mm};
  const PlatePoint high{place.x + reach_mm, place.y + reach_mm, range.high_mm};
  for_each_facet(low, high, [&](const PlacedFacet& facet) {
    const Vector normal = normal_of(facet.a, facet.b, facet.c);
    if (!(normal.z < 0)) return;
    const Nearest nearest = nearest_on(facet.a, facet.b, facet.c, place);
    if (nearest.squared_distance > reach_mm * reach_mm) return;
    if (nearest.point.z < range.low_mm || nearest.point.z > range.high_mm) return;
    // As much of it as can lie within reach.
    const double length = std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
    const double weight = std::min(1.0, 8 * reach_mm * reach_mm / length);
    sum = {sum.x + weight * normal.x, sum.y + weight * normal.y, sum.z + weight * normal.z};
    if (nearest.squared_distance > best_distance) return;
    if (nearest.squared_distance == best_distance && z_mm && *z_mm <= nearest.point.z) return;
    best_distance = nearest.squared_distance;
    z_mm = nearest.point.z;
  });
  if (!z_mm) return std::nullopt;
  return Surface{*z_mm, outward_of(sum)};
}

}  // namespace contourd
