#include "core/support/support_primitive.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/core/support/random_primitives.hpp"

namespace {

constexpr double kPi = std::numbers::pi;

Contours outline(const SupportPrimitive& primitive, double z) {
  Contours contours;
  if (const auto cut = cut_at(primitive, z)) append_outline(*cut, contours);
  return contours;
}

double area(const SupportPrimitive& primitive, double z) {
  const Contours contours = outline(primitive, z);
  return contours.loops.empty() ? 0 : signed_area(contours.points_of(contours.loops[0]));
}

// A polygon within kChordErrorMm of a convex outline, with its corners on the outline, has a smaller area by
// less than kChordErrorMm times the outline's length.
double area_error(double perimeter_mm) {
  return perimeter_mm * kChordErrorMm;
}

const Frustum kUpright{{1, 2, 3}, {1, 2, 8}, 2, 0.5};

}  // namespace

TEST_CASE("An upright frustum is cut as a circle, from its lower end to below its upper one") {
  for (const double z : {3.0, 4.0, 6.5, 7.999}) {
    const double radius = 2 - 0.3 * (z - 3);
    CHECK(std::fabs(area(kUpright, z) - kPi * radius * radius) < area_error(2 * kPi * radius));
  }
  for (const double z : {2.999999, 8.0, 9.0})
    CHECK(outline(kUpright, z).loops.empty());
}

TEST_CASE("A tilted cylinder is cut as an ellipse that is as much wider as it leans") {
  const Frustum leaning{{0, 0, 0}, {6, 8, 10}, 0.5, 0.5};  // by 45 degrees
  const double wanted = kPi * 0.5 * 0.5 * std::sqrt(2);
  CHECK(std::fabs(area(leaning, 5) - wanted) < area_error(2 * kPi * 0.71));
  const Contours contours = outline(leaning, 5);
  double farthest = 0;
  for (const Point& p : contours.points)
    farthest = std::max(farthest, std::hypot(p.x - 3, p.y - 4));
  CHECK(farthest == Approx(0.5 * std::sqrt(2)).margin(1e-9));
}

TEST_CASE("A horizontal cylinder is cut as a rectangle, and a horizontal cone along a hyperbola") {
  const Frustum cylinder{{-1, 0, 2}, {4, 0, 2}, 0.5, 0.5};
  CHECK(area(cylinder, 2) == Approx(5 * 1.0).epsilon(1e-12));
  CHECK(outline(cylinder, 2).points.size() == 4);
  CHECK(area(cylinder, 2.3) == Approx(5 * 0.8).epsilon(1e-12));
  CHECK(outline(cylinder, 2.5).loops.empty());
  // For t from 5 h to 5, v^2 = (t / 5)^2 - h^2: a hyperbola, whose area has a formula.
  const Frustum cone{{0, 0, 2}, {5, 0, 2}, 0, 1};
  const double h = 0.5;
  const double wanted = 5 * (std::sqrt(1 - h * h) - h * h * std::acosh(1 / h));
  CHECK(std::fabs(area(cone, 2.5) - wanted) < area_error(8));
  CHECK(area(cone, 2) == Approx(5 * 1.0).epsilon(1e-9));
}

TEST_CASE("A cone that leans as much as it widens is cut along a parabola") {
  // One side of the cone's surface is horizontal: a slope of 3 in 4, with a half angle whose tangent is 3/4
  // and an axis that rises by 3 in 5 of its length.
  const Frustum cone{{0, 0, 0}, {4, 0, 3}, 0, 3.75};
  for (const double z : {0.5, 1.5, 4.0, 5.9}) {
    const Contours contours = outline(cone, z);
    REQUIRE(contours.loops.size() == 1);
    for (const Point& p : contours.points)
      CHECK(std::fabs(outside(cone, {p.x, p.y, z})) < 1e-9);
  }
}

TEST_CASE("A tip of radius 0 is cut up to its point") {
  const Frustum tip{{0, 0, 0}, {0, 0, 1}, 0.5, 0};
  CHECK(std::fabs(area(tip, 0.999) - kPi * 0.0005 * 0.0005) < area_error(2 * kPi * 0.0005));
  CHECK(outline(tip, 1).loops.empty());
  const Frustum leaning{{0, 0, 0}, {0.6, 0, 0.8}, 0.5, 0};
  CHECK(area(leaning, 0.799) > 0);
  CHECK(outline(leaning, 0.8).loops.empty());
}

TEST_CASE("A ball is cut as a circle") {
  const Ball ball{{1, 2, 3}, 2};
  for (const double z : {1.001, 2.0, 3.0, 4.9}) {
    const double squared = 4 - (z - 3) * (z - 3);
    CHECK(std::fabs(area(ball, z) - kPi * squared) < area_error(2 * kPi * std::sqrt(squared)));
  }
  CHECK(outline(ball, 1).loops.empty());
  CHECK(outline(ball, 5).loops.empty());
}

TEST_CASE("An end of a tilted frustum is cut off straight") {
  const Frustum leaning{{0, 0, 0}, {3, 0, 4}, 1, 1};
  // At the height of the lower end's middle, the plane of that end goes through the middle of the ellipse.
  CHECK(std::fabs(area(leaning, 0) - kPi * 1 * 1.25 / 2) < area_error(8));
  // The cut begins where the end's disc does: six tenths of its radius of 1 mm further down.
  const auto reach = reach_of(leaning);
  CHECK(reach.bottom == Approx(-0.6));
  CHECK(reach.top == Approx(4.6));
  CHECK(outline(leaning, -0.6001).loops.empty());
  CHECK_FALSE(outline(leaning, -0.599).loops.empty());
}

TEST_CASE("Every corner is on the primitive's surface, every side near to it, and the outline is convex") {
  CHECK(rc::check([] {
    const SupportPrimitive primitive = draw_primitive();
    const HeightReach reach = reach_of(primitive);
    const double z = draw_real(reach.bottom, reach.top);
    const Contours contours = outline(primitive, z);
    if (contours.loops.empty()) return;
    const std::span<const Point> corners = contours.points_of(contours.loops[0]);
    RC_ASSERT(corners.size() <= static_cast<std::size_t>(kMostCorners));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % corners.size()],
                  &c = corners[(i + 2) % corners.size()];
      RC_ASSERT(std::fabs(outside(primitive, {a.x, a.y, z})) < 1e-7);
      // Rounding of three corners on one line may make a tiny turn to the right.
      RC_ASSERT((b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x) > -1e-9);
      // The middle of a side, moved outwards, must leave the primitive. The distance from the surface is no
      // measure here, since it is smaller where the surface is not vertical.
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      if (length < 1e-6) continue;
      const double off = 1.05 * kChordErrorMm / length;
      const PlatePoint beyond{(a.x + b.x) / 2 + (b.y - a.y) * off, (a.y + b.y) / 2 - (b.x - a.x) * off, z};
      RC_ASSERT(outside(primitive, beyond) > 0);
    }
    RC_ASSERT(signed_area(corners) > 0);
  }));
}

namespace {

// Returns the frustum as a body of revolution with 720 sides, which are up to 0.02 um inside it for each
// millimetre of radius; corners are rounded to float.
models::Facets fine_mesh(const Frustum& frustum) {
  const Space axis = between(frustum.lower, frustum.upper);
  const double length = std::sqrt(dot(axis, axis)), level = std::hypot(axis.x, axis.y);
  const Space w{axis.x / length, axis.y / length, axis.z / length};
  const Space u = level == 0 ? Space{1, 0, 0} : Space{-axis.y / level, axis.x / level, 0};
  const Space v{w.y * u.z - w.z * u.y, w.z * u.x - w.x * u.z, w.x * u.y - w.y * u.x};
  std::vector<Point> profile{{0, 0}, {frustum.lower_radius_mm, 0}};
  if (frustum.upper_radius_mm > 0) profile.push_back({frustum.upper_radius_mm, length});
  profile.push_back({0, length});
  if (frustum.lower_radius_mm == 0) profile.erase(profile.begin());
  models::Facets facets = models::lathe(profile, 720);
  for (Facet& facet : facets) {
    for (Vertex& at : facet.vertices) {
      const double a = at.x, b = at.y, c = at.z;
      at = {static_cast<float>(frustum.lower.x + a * u.x + b * v.x + c * w.x),
            static_cast<float>(frustum.lower.y + a * u.y + b * v.y + c * w.y),
            static_cast<float>(frustum.lower.z + a * u.z + b * v.z + c * w.z)};
    }
  }
  return facets;
}

double distance_to_side(const Point& p, const Point& a, const Point& b) {
  const double x = b.x - a.x, y = b.y - a.y, squared = x * x + y * y;
  const double share =
      squared > 0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / squared, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - share * x, p.y - a.y - share * y);
}

double distance_to(std::span<const Point> loop, const Point& p) {
  double least = 1e9;
  for (std::size_t i = 0; i < loop.size(); ++i)
    least = std::min(least, distance_to_side(p, loop[i], loop[(i + 1) % loop.size()]));
  return least;
}

}  // namespace

TEST_CASE("A cut has the area and the outline of a sliced fine mesh of the frustum") {
  CHECK(rc::check([] {
    const Frustum frustum = draw_frustum();
    const HeightReach reach = reach_of(frustum);
    const double z = draw_real(reach.bottom, reach.top);
    const auto cut = cut_at(frustum, z);
    // Where the plane nearly touches the surface, the mesh's error is multiplied along the plane; from 0.1 mm
    // on by at most 2 mm / 0.1 mm, which makes 0.001 mm.
    if (!cut || cut->half_width() < 0.1 || cut->high - cut->low < 0.2) return;
    const Contours exact = outline(frustum, z), sliced = contours_of(fine_mesh(frustum), z);
    RC_ASSERT(sliced.loops.size() == 1U);
    const auto of_exact = exact.points_of(exact.loops[0]), of_sliced = sliced.points_of(sliced.loops[0]);
    RC_ASSERT(std::fabs(signed_area(of_exact) - signed_area(of_sliced)) < 0.002 * perimeter_mm(sliced));
    for (const Point& p : of_exact)
      RC_ASSERT(distance_to(of_sliced, p) < 0.002);
    for (const Point& p : of_sliced)
      RC_ASSERT(distance_to(of_exact, p) < 0.002);
  }));
}

TEST_CASE("A cut contains the points of its height that are in the primitive, and no others") {
  CHECK(rc::check([] {
    const SupportPrimitive primitive = draw_primitive();
    const double z = draw_real(-2, 8);
    const PlatePoint point{draw_real(-6, 6), draw_real(-6, 6), z};
    const auto cut = cut_at(primitive, z);
    const double off = outside(primitive, point);
    if (std::fabs(off) < 1e-9) return;
    bool held = false;
    if (cut) {
      const double x = point.x - cut->origin.x, y = point.y - cut->origin.y;
      const double u = x * cut->along.x + y * cut->along.y, v = y * cut->along.x - x * cut->along.y;
      held = cut->low <= u && u <= cut->high && v * v <= cut->first.at(u) * cut->second.at(u);
    }
    RC_ASSERT(held == (off < 0));
  }));
}
