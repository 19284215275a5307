#include "core/orientation/orientation_rating.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

using Mesh = OrientationRating::Mesh;

OrientationFigures rated(const models::Facets& facets, const Direction& up, Mesh kind = Mesh::Whole,
                         const OrientationRequest& request = {}) {
  const RatedMesh mesh({.facets = facets, .cell_mm = kContactCellMm, .keep_clean = request.keep_clean});
  return OrientationRating(mesh, request, kind).rate(up);
}

// Returns a shelf of this depth and a thickness of 2 that sticks out of a wall at a height of 10, in one
// mesh; fine along x.
models::Facets shelf(double depth_mm) {
  const Point profile[]{
      {0, 0}, {5, 0}, {5, 10}, {5 + depth_mm / 2, 10}, {5 + depth_mm, 10}, {5 + depth_mm, 12}, {0, 12}};
  return models::lathe(profile, 90);
}

}  // namespace

TEST_CASE("A cube stands on its face and needs no supports") {
  const OrientationFigures figures = rated(models::box({0, 0, 0}, {10, 20, 30}), {0, 0, 1});
  CHECK(figures.stands);
  CHECK(figures.contacts == 0);
  CHECK(figures.support_mm3 == 0);
  CHECK(figures.standing_mm2 == 200);
  CHECK(figures.size_x_mm == 10);
  CHECK(figures.size_y_mm == 20);
  CHECK(figures.size_z_mm == 30);
  CHECK(std::abs(figures.largest_mm2 - 200) < 1e-9);  // rounding
}

TEST_CASE("Figures are those of the model as scaled along the plate's axes") {
  const OrientationRequest request{.scale = {2, 3, 4}};
  const OrientationFigures figures =
      rated(models::box({0, 0, 0}, {10, 20, 30}), {1, 0, 0}, Mesh::Whole, request);
  CHECK(std::abs(figures.size_x_mm - 60) < 1e-9);  // the model's z, turned level
  CHECK(std::abs(figures.size_y_mm - 60) < 1e-9);
  CHECK(std::abs(figures.size_z_mm - 40) < 1e-9);
  CHECK(std::abs(figures.largest_mm2 - 3600) < 1e-6);
}

TEST_CASE("The largest section is found without a cut") {
  const models::Facets ball = models::sphere(10, 40);
  // A ball's equator; its facets lie inside the ball, by up to a hundredth at this fineness.
  const double largest = rated(ball, {0, 0, 1}).largest_mm2;
  CHECK(largest < std::numbers::pi * 100);
  CHECK(largest > std::numbers::pi * 99);
  // A cone of few, long facets: cut by all heights. The lowest is a 128th of the height above the base.
  const models::Facets cone = models::cone(10, 20, 360);
  const double share = 1 - 1 / 128.0;
  CHECK(std::abs(rated(cone, {0, 0, 1}).largest_mm2 - std::numbers::pi * 100 * share * share) < 0.05);
  CHECK(std::abs(rated(cone, {0, 0, -1}).largest_mm2 - std::numbers::pi * 100 * share * share) < 0.05);
}

TEST_CASE("A model that stands on a point is supported there, and lifted") {
  const OrientationRequest request{.supports = {.lift = Millimeters{5}}};
  const OrientationFigures figures = rated(models::cone(2, 20, 32), {0, 0, -1}, Mesh::Whole, request);
  CHECK_FALSE(figures.stands);
  CHECK(figures.contacts == 1);
  // A pillar of 1 mm diameter and 5 mm height, and the extra volume of its foot.
  CHECK(std::abs(figures.support_mm3 - (5 * std::numbers::pi / 4 + 4.7)) < 1e-4);
}

TEST_CASE("A sample is rated without the points on which a model begins") {
  CHECK(rated(models::cone(2, 20, 32), {0, 0, -1}, Mesh::Sample).contacts == 0);
}

TEST_CASE("A ledge needs supports if it reaches farther than can be bridged") {
  CHECK(rated(shelf(1), {0, 0, 1}).overhang_mm2 == 0);
  const double half_held = rated(shelf(6), {0, 0, 1}).overhang_mm2;
  CHECK(half_held > 100);
  CHECK(half_held < std::numbers::pi * (121 - 25));
  const OrientationRequest bold{.supports = {.bridge = Millimeters{20}}};
  CHECK(rated(shelf(6), {0, 0, 1}, Mesh::Whole, bold).overhang_mm2 == 0);
}

TEST_CASE("A table upside down needs no supports, but on its legs its top does") {
  const models::Facets table =
      together({models::box({0, 0, 20}, {40, 40, 23}), models::box({0, 0, 0}, {5, 5, 23}),
                models::box({35, 0, 0}, {40, 5, 23}), models::box({0, 35, 0}, {5, 40, 23}),
                models::box({35, 35, 0}, {40, 40, 23})});
  CHECK(rated(table, {0, 0, -1}).contacts == 0);
  CHECK(rated(table, {0, 0, -1}).stands);
  // 1600 mm2; one contact holds 11.1.
  CHECK(std::abs(rated(table, {0, 0, 1}).contacts - 1600 / kContactHoldsMm2) < 1e-6);
  CHECK(rated(table, {0, 0, 1}).stands);
}

TEST_CASE("The bottom of a pit is no place on which a model begins") {
  const Point profile[]{{0, 0}, {10, 0}, {10, 10}, {0, 5}};
  CHECK(rated(models::lathe(profile, 32), {0, 0, 1}).contacts == 0);
  // Upside down the pit is a roof that its rim carries, no farther than can be bridged.
  CHECK(rated(models::lathe(profile, 32), {0, 0, -1}).contacts > 0);
}

TEST_CASE("A face that is too small for the peeled area does not hold the model") {
  const models::Facets pin =
      together({models::box({4.5, 4.5, 0}, {5.5, 5.5, 10}), models::box({0, 0, 10}, {10, 10, 20})});
  CHECK_FALSE(rated(pin, {0, 0, 1}).stands);
  CHECK(rated(pin, {0, 0, -1}).stands);
}

TEST_CASE("A surface to be kept clean is touched where it hangs over or stands on the plate") {
  OrientationRequest request;
  request.keep_clean = {Direction{0, 0, 1}};
  const models::Facets cube = models::box({0, 0, 0}, {10, 10, 10});
  CHECK(rated(cube, {0, 0, 1}, Mesh::Whole, request).touched_mm2 == 0);
  CHECK(rated(cube, {0, 0, -1}, Mesh::Whole, request).touched_mm2 == 100);
  CHECK(std::abs(rated(cube, {1, 0, -2}, Mesh::Whole, request).touched_mm2 - 200 / std::sqrt(5.0)) < 1e-4);
}

TEST_CASE("A model that does not stand must fit with its lift") {
  OrientationRequest request{.build = BuildSize{Millimeters{30}, Millimeters{30}, Millimeters{22}},
                             .supports = {.lift = Millimeters{5}}};
  const models::Facets cone = models::cone(5, 20, 16);
  CHECK(rated(cone, {0, 0, 1}, Mesh::Whole, request).fits);
  CHECK_FALSE(rated(cone, {0, 0, -1}, Mesh::Whole, request).fits);
  request.build->width = Millimeters{9};
  CHECK_FALSE(rated(cone, {0, 0, 1}, Mesh::Whole, request).fits);
}
