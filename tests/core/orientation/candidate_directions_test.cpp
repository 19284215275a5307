#include "core/orientation/orientation_choice.hpp"

#include <algorithm>
#include <cmath>

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
    for (std::size_t j = 0; j < i; ++j)
      CHECK(dot(directions[i], directions[j]) < 0.9987);  // 3 degrees
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

TEST_CASE("A model without area has the axes and the evenly spread directions") {
  const Vertex v{1, 1, 1};
  const Facet facets[]{{{v, v, v}}};
  CHECK(candidate_directions(facets).size() > 200);
}
