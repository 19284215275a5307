#include "core/placement.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/mesh_report.hpp"
#include "tests/catch.hpp"
#include "tests/core/random_shapes.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using testing::draw_real;

namespace {

Vertex oriented(Vertex v, const Orientation& orientation) {
  Facet facets[]{{{v, v, v}}};
  orient(facets, orientation);
  return facets[0].vertices[1];
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
  CHECK(oriented({1, -2, 3}, {0, 0, 0, 2.5}) == Vertex{2.5F, -5, 7.5F});
  CHECK(oriented({1, -2, 3}, {0, 0, 90, 25.4}) == Vertex{50.8F, 25.4F, 76.2F});
}

TEST_CASE("Any turn is the product of its three rotations rounded once") {
  CHECK(rc::check([] {
    const Orientation turn{draw_real(-360, 360), draw_real(-360, 360), draw_real(-360, 360),
                           draw_real(0.1, 10)};
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
    RC_ASSERT(std::fabs(result.x - x * turn.scale) <= kFloatRoundingMm);
    RC_ASSERT(std::fabs(result.y - y * turn.scale) <= kFloatRoundingMm);
    RC_ASSERT(std::fabs(result.z - z * turn.scale) <= kFloatRoundingMm);
  }));
}

TEST_CASE("No turn and no scale leave every bit alone") {
  CHECK(Orientation{}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 0, 2}.is_identity());
  CHECK_FALSE(Orientation{1, 0, 0}.is_identity());
  CHECK_FALSE(Orientation{0, 1, 0}.is_identity());
  CHECK_FALSE(Orientation{0, 0, 1}.is_identity());
  const Vertex v = oriented({-0.0F, 1e-45F, 3e38F}, {});
  CHECK(std::bit_cast<std::uint32_t>(v.x) == 0x80000000U);
  CHECK(v == Vertex{0, 1e-45F, 3e38F});
}

TEST_CASE("A closed model stays closed and keeps its volume times the scale cubed") {
  const models::Facets sphere = models::sphere(10, 10);
  const double volume = inspect_mesh(sphere).volume_mm3;
  CHECK(rc::check([&] {
    models::Facets facets = sphere;
    const double scale = draw_real(0.5, 2);
    orient(facets, {draw_real(0, 360), draw_real(0, 360), draw_real(0, 360), scale});
    const MeshReport report = inspect_mesh(facets);
    RC_ASSERT(report.watertight);
    // Floats of 20 mm are rounded by 1e-6 mm, 1e-7 of the radius: three times that of the volume, to be safe
    // ten.
    RC_ASSERT(std::fabs(report.volume_mm3 / (volume * scale * scale * scale) - 1) < 1e-6);
  }));
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
