#include "core/orientation/candidate_directions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/orientation/rated_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

double nearest_deg(const std::vector<Direction>& directions, const Direction& wanted) {
  double nearest = -1;
  for (const Direction& each : directions)
    nearest = std::max(nearest, dot(each, wanted) / length_of(wanted));
  return std::acos(std::min(1.0, nearest)) * 180 / 3.14159265358979;
}

}  // namespace

TEST_CASE("The drawn orientation is tried first") {
  CHECK(candidate_directions(models::cone(5, 10, 16)).front() == Direction{0, 0, 1});
}

TEST_CASE("Every direction is within 13 degrees of one that is tried") {
  const std::vector<Direction> directions = candidate_directions(models::box({0, 0, 0}, {1, 2, 3}));
  CHECK(directions.size() <= kMostDirections);
  // 200 circles of 8 degrees have the area of the sphere; their arrangement needs some more.
  for (const Direction& wanted :
       {Direction{1, 1, 1}, Direction{-1, 0.2, 0.3}, Direction{0.7, -0.1, 0}, Direction{0.3, 0.1, -1}})
    CHECK(nearest_deg(directions, wanted) < 13);
}

TEST_CASE("Directions that are tried have length 1 and are apart") {
  const std::vector<Direction> directions = candidate_directions(models::sphere(10, 24));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    CHECK(std::abs(length_of(directions[i]) - 1) < 1e-12);  // rounding
    for (std::size_t j = 1; j < i; ++j)                     // from (0, 0, 1), faces may be at any angle
      CHECK(dot(directions[i], directions[j]) < 0.9987);    // 3 degrees
  }
}

TEST_CASE("Directions that put a flat face on the plate are tried") {
  models::Facets facets = models::box({0, 0, 0}, {10, 20, 30});
  orient(facets, {.up = Direction{1, 2, 3}});
  const std::vector<Direction> directions = candidate_directions(facets);
  // The box's own axes, as turned.
  const PlateAxes axes = axes_with_up({1, 2, 3});
  for (const Direction& axis :
       {Direction{axes.right.x, axes.back.x, axes.up.x}, Direction{-axes.right.z, -axes.back.z, -axes.up.z}})
    CHECK(nearest_deg(directions, axis) < 0.01);  // float's rounding
}

TEST_CASE("A base that is nearly level is tried exactly level, and so is the top") {
  for (const double tilt_deg : {0.01, 0.06, 0.4, 2.0, 5.0}) {
    models::Facets disc = models::lathe(std::vector<Point>{{0, 0}, {25, 0}, {25, 3}, {24, 4}, {0, 4}}, 64);
    orient(disc, {.x_deg = tilt_deg, .y_deg = tilt_deg / 3});
    const Direction base = area_of(disc.front());
    const Direction up{-base.x, -base.y, -base.z}, down = base;
    const auto off = [&](const Direction& wanted) {
      double least = 1e9;
      for (const Direction& each : candidate_directions(disc)) {
        const double size = length_of(wanted);
        least = std::min(
            least, length_of({each.x - wanted.x / size, each.y - wanted.y / size, each.z - wanted.z / size}));
      }
      return least;
    };
    INFO(tilt_deg);
    CHECK(off(up) < 2e-5);  // radians: 1 um over 50 mm
    CHECK(off(down) < 2e-5);
  }
}

TEST_CASE("A level base is tried once") {
  const std::vector<Direction> directions = candidate_directions(models::box({0, 0, 0}, {10, 20, 30}));
  CHECK(std::ranges::count_if(directions, [](const Direction& each) { return each.z > 0.9999; }) == 1);
}

TEST_CASE("A flat face keeps its direction beside facets that are nearly level with it") {
  // The dome's facets lie within the 2 degrees of the base's normal, mirrored.
  const Point profile[]{{0, 0}, {10, 0.15}, {10.1, 0.1}, {40, 0.1}, {40, 5}, {0, 5}};
  models::Facets plate = models::lathe(profile, 64);
  orient(plate, {.x_deg = 1});
  const Direction base = axes_with_up({0, 0, 1}).up;
  const double tilt = 1 * std::numbers::pi / 180;
  CHECK(nearest_deg(candidate_directions(plate), {base.x, -std::sin(tilt), std::cos(tilt)}) < 0.002);
}

TEST_CASE("A model without area has the axes and the evenly spread directions") {
  const Vertex v{1, 1, 1};
  const Facet facets[]{{{v, v, v}}};
  CHECK(candidate_directions(facets).size() > 200);
}
