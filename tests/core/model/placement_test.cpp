#include "core/model/placement.hpp"

#include <bit>

#include "core/contour/filled_area.hpp"
#include "core/model/mesh_report.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

Vertex oriented(Vertex v, const Orientation& orientation) {
  Facet facets[]{{{v, v, v}}};
  orient(facets, orientation);
  return facets[0].vertices[1];
}

double area_at(const HeightIndex& model, double z) {
  Section section;
  slice_at(model, Millimeters{z}, section);
  Contours contours;
  ContourLinker().link(section.segments, Millimeters{0.01}, contours);
  return filled_area_mm2(contours);
}

double degrees(double deg) {
  return deg * std::numbers::pi / 180;
}

}  // namespace

TEST_CASE("Quarter turns are exact and right-handed") {
  const Vertex v{0.1F, 2.3F, -4.7F};
  CHECK(oriented(v, {90, 0, 0}) == Vertex{0.1F, 4.7F, 2.3F});
  CHECK(oriented(v, {0, 90, 0}) == Vertex{-4.7F, 2.3F, -0.1F});
  CHECK(oriented(v, {0, 0, 90}) == Vertex{-2.3F, 0.1F, -4.7F});
  CHECK(oriented(v, {180, 0, 0}) == Vertex{0.1F, -2.3F, 4.7F});
  CHECK(oriented(v, {0, 0, -90}) == Vertex{2.3F, -0.1F, -4.7F});
}

TEST_CASE("Full turns may be added to any angle") {
  const Vertex v{0.1F, 2.3F, -4.7F};
  CHECK(oriented(v, {0, 0, 360}) == v);
  CHECK(oriented(v, {-720, 360, 1080}) == v);
  CHECK(oriented(v, {450, 0, 0}) == oriented(v, {90, 0, 0}));
  CHECK(oriented(v, {0, 270, 0}) == oriented(v, {0, -90, 0}));
  CHECK(oriented(v, {0, 0, 540}) == oriented(v, {0, 0, 180}));
}

TEST_CASE("The axes stay fixed and x comes before y before z") {
  // x to y about z only at the end: first y to z, then z to x, then x to y.
  CHECK(oriented({0, 1, 0}, {90, 90, 90}) == Vertex{0, 1, 0});
  CHECK(oriented({0, 1, 0}, {90, 90, 0}) == Vertex{1, 0, 0});
  CHECK(oriented({1, 0, 0}, {90, 0, 90}) == Vertex{0, 1, 0});
  CHECK(oriented({0, 1, 0}, {90, 0, 90}) == Vertex{0, 0, 1});
}

TEST_CASE("The scale applies to all axes") {
  CHECK(oriented({1, -2, 3}, {0, 0, 0, Scale{2.5}}) == Vertex{2.5F, -5, 7.5F});
  CHECK(oriented({1, -2, 3}, {0, 0, 90, Scale{25.4}}) == Vertex{50.8F, 25.4F, 76.2F});
}

TEST_CASE("Any turn is the product of its three rotations rounded once") {
  CHECK(rc::check([] {
    const Orientation turn{draw_real(-360, 360),
                           draw_real(-360, 360),
                           draw_real(-360, 360),
                           {draw_real(0.1, 10), draw_real(0.1, 10), draw_real(0.1, 10)}};
    const Vertex v = testing::draw_vertex(100);
    double x = v.x, y = v.y, z = v.z;
    const auto rotate = [](double& a, double& b, double deg) {
      const double c = std::cos(degrees(deg)), s = std::sin(degrees(deg));
      const double turned = c * a - s * b;
      b = s * a + c * b;
      a = turned;
    };
    rotate(y, z, turn.x_deg);
    rotate(z, x, turn.y_deg);
    rotate(x, y, turn.z_deg);
    const Vertex result = oriented(v, turn);
    // Lengths up to 1733 mm: a float's rounding there is 2^-14 mm.
    constexpr double kFloatRoundingMm = 1.0 / (1 << 14);
    RC_ASSERT(std::fabs(result.x - x * turn.scale.x) <= kFloatRoundingMm);
    RC_ASSERT(std::fabs(result.y - y * turn.scale.y) <= kFloatRoundingMm);
    RC_ASSERT(std::fabs(result.z - z * turn.scale.z) <= kFloatRoundingMm);
  }));
}

TEST_CASE("Without turn and scale every bit stays the same") {
  CHECK(Orientation{}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 0, Scale{2}}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 0, Scale{1, 1, 2}}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 0, {}, Direction{}}.is_identity());
  CHECK_FALSE(Orientation{1, 0, 0}.is_identity());
  CHECK_FALSE(Orientation{0, 1, 0}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 1}.is_identity());
  const Vertex v = oriented({-0.0F, 1e-45F, 3e38F}, {});
  CHECK(std::bit_cast<std::uint32_t>(v.x) == 0x80000000U);
  CHECK(v == Vertex{0, 1e-45F, 3e38F});
}

TEST_CASE("Every facet is turned") {
  models::Facets facets = models::box({0, 0, 0}, {1, 2, 3});
  orient(facets, {0, 0, 90});
  const Bounds bounds = bounds_of(facets);
  CHECK(bounds.min_x == -2);
  CHECK(bounds.max_x == 0);
  CHECK(bounds.max_y == 1);
  CHECK(bounds.max_z == 3);
}

TEST_CASE("Each axis can have its own scale, along the plate's axes after the turn") {
  CHECK(oriented({1, -2, 3}, {0, 0, 0, {2, 0.5, 4}}) == Vertex{2, -1, 12});
  CHECK(oriented({1, -2, 3}, {0, 0, 90, {2, 0.5, 4}}) == Vertex{4, 0.5F, 12});
}

namespace {

Orientation upwards(double x, double y, double z) {
  Orientation turn;
  turn.up = Direction{x, y, z};
  return turn;
}

Direction draw_direction() {
  Direction n{draw_real(-1, 1), draw_real(-1, 1), draw_real(-1, 1)};
  if (n.x == 0 && n.y == 0 && n.z == 0) n.z = 1;
  return n;
}

// The rounding of floats of up to 2: half of 2^-23.
constexpr double kUnitRounding = 1e-7;

}  // namespace

TEST_CASE("A direction along an axis is exact, whatever its length") {
  const Vertex v{0.1F, 2.3F, -4.7F};
  for (const double length : {1.0, 1e-300, 7.3, 1e300}) {
    CHECK(oriented(v, upwards(0, 0, length)) == v);
    CHECK(oriented(v, upwards(0, 0, -length)) == Vertex{0.1F, -2.3F, 4.7F});
    CHECK(oriented(v, upwards(length, 0, 0)) == Vertex{4.7F, 2.3F, 0.1F});
    CHECK(oriented(v, upwards(-length, 0, 0)) == Vertex{-4.7F, 2.3F, -0.1F});
    CHECK(oriented(v, upwards(0, length, 0)) == Vertex{0.1F, 4.7F, 2.3F});
    CHECK(oriented(v, upwards(0, -length, 0)) == Vertex{0.1F, -4.7F, -2.3F});
  }
}

TEST_CASE("A direction is turned straight up, and the axis across both stays where it is") {
  CHECK(rc::check([] {
    const Direction n = draw_direction();
    const double length = std::hypot(n.x, n.y, n.z), flat = std::hypot(n.x, n.y);
    const auto unit = [](double x, double y, double z) {
      return Vertex{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    };
    const Vertex up = oriented(unit(n.x / length, n.y / length, n.z / length), upwards(n.x, n.y, n.z));
    RC_ASSERT(std::hypot(up.x, up.y, up.z - 1) < 4 * kUnitRounding);
    RC_PRE(flat > 1e-6);
    // The shortest rotation turns about n x (0, 0, 1).
    const Vertex axis = unit(n.y / flat, -n.x / flat, 0);
    const Vertex kept = oriented(axis, upwards(n.x, n.y, n.z));
    RC_ASSERT(std::hypot(kept.x - axis.x, kept.y - axis.y, kept.z) < 4 * kUnitRounding);
  }));
}

TEST_CASE("Directions near straight down are as exact as any other") {
  for (const double off : {1e-3, 1e-7, 1e-9, 1e-15, 1e-160, 1e-300}) {
    const Vertex v = oriented({0, 0, -1}, upwards(off, off / 2, -1));
    CHECK(std::hypot(v.x, v.y, v.z - 1) < 2 * off + 4 * kUnitRounding);
    // Still a rotation: lengths and angles are kept.
    const Vertex x = oriented({1, 0, 0}, upwards(off, off / 2, -1));
    const Vertex y = oriented({0, 1, 0}, upwards(off, off / 2, -1));
    CHECK(std::fabs(std::hypot(x.x, x.y, x.z) - 1) < 4 * kUnitRounding);
    CHECK(std::fabs(static_cast<double>(x.x) * y.x + static_cast<double>(x.y) * y.y +
                    static_cast<double>(x.z) * y.z) < 4 * kUnitRounding);
  }
}

TEST_CASE("A turned model stays closed, with its volume times the three factors") {
  const models::Facets sphere = models::sphere(10, 10);
  const double volume = inspect_mesh(sphere).volume_mm3;
  CHECK(rc::check([&] {
    models::Facets facets = sphere;
    const bool by_angles = draw(0, 1) == 1, evenly = draw(0, 1) == 1;
    Orientation turn;
    if (by_angles) turn = {draw_real(0, 360), draw_real(0, 360), draw_real(0, 360)};
    if (!by_angles) turn.up = draw_direction();
    turn.scale = Scale{draw_real(0.5, 2)};
    if (!evenly) turn.scale = {draw_real(0.5, 2), draw_real(0.5, 2), draw_real(0.5, 2)};
    orient(facets, turn);
    const MeshReport report = inspect_mesh(facets);
    RC_ASSERT(report.watertight);
    // Floats of 20 mm are rounded by 1e-6 mm, 1e-7 of the radius: three times that for the volume; ten to be
    // safe.
    RC_ASSERT(std::fabs(report.volume_mm3 / (volume * turn.scale.x * turn.scale.y * turn.scale.z) - 1) <
              1e-6);
  }));
}

TEST_CASE("A direction and the angles that point it up give the same sections") {
  CHECK(rc::check([] {
    const Direction n = draw_direction();
    // About z until n lies above the x axis, then about y: two steps, as the angles are applied x, y, z.
    const double turn_deg = -std::atan2(n.y, n.x) * 180 / std::numbers::pi;
    const double tilt_deg = -std::atan2(std::hypot(n.x, n.y), n.z) * 180 / std::numbers::pi;
    const models::Facets model = models::box({-4, -2, -1}, {5, 3, 7});
    models::Facets by_direction = model, by_angles = model;
    orient(by_direction, upwards(n.x, n.y, n.z));
    orient(by_angles, {0, 0, turn_deg});
    orient(by_angles, {0, tilt_deg, 0});
    const HeightIndex one(by_direction), other(by_angles);
    // Floats of some 10 mm; the angles' version is rounded twice.
    constexpr double kRoundingMm = 4e-6;
    RC_ASSERT(std::fabs(one.bounds().min_z - other.bounds().min_z) < kRoundingMm);
    RC_ASSERT(std::fabs(one.bounds().max_z - other.bounds().max_z) < kRoundingMm);
    const double z = one.bounds().min_z + draw_real(0.05, 0.95) * one.bounds().size_z();
    // An area changes by at most some 40 mm of perimeter times how far a side moves; a side as flat as 1:1000
    // moves by a thousand roundings.
    RC_ASSERT(std::fabs(area_at(one, z) - area_at(other, z)) < 40 * 1000 * kRoundingMm);
    RC_ASSERT(area_at(one, z) > 0);
  }));
}
