#include "core/orientation/orientation_trial.hpp"

#include <cmath>

#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/rated_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

OrientationTrial tried(const models::Facets& facets, const Direction& up = {0, 0, 1},
                       const OrientationRequest& request = {}) {
  const RatedMesh mesh({.facets = facets, .cell_mm = kContactCellMm});
  return try_orientation(facets, OrientationRating(mesh, request, OrientationRating::Mesh::Whole).rate(up),
                         request);
}

// Returns rods of 1 mm, side by side, that narrow to a point of this radius below a block.
models::Facets block_on_rods(double tip_mm) {
  models::Facets model = models::box({0, 0, 6}, {20, 20, 10});
  const Point profile[]{{0, 0}, {0.6, 0}, {0.6, 5}, {tip_mm, 6}, {tip_mm, 6.1}, {0, 6.1}};
  for (int i = 0; i < 9; ++i) {
    models::Facets rod = models::lathe(profile, 16);
    models::translate(rod, 3 + 7 * static_cast<float>(i % 3), 3 + 7 * static_cast<float>(i / 3), 0);
    model = together(model, rod);
  }
  return model;
}

}  // namespace

TEST_CASE("A trial finds a cone on its point held and lifted, and on its base neither") {
  const OrientationTrial on_point = tried(models::cone(5, 20, 48), {0, 0, -1});
  CHECK(on_point.figures.tried);
  CHECK_FALSE(on_point.figures.stands);
  CHECK(on_point.figures.contacts > 0);
  // Each support is at least as high as the lift.
  CHECK(on_point.figures.support_mm3 >= on_point.figures.contacts * pillar_mm3(5));
  const OrientationTrial on_base = tried(models::cone(5, 20, 48));
  CHECK(on_base.figures.stands);
  CHECK(on_base.figures.contacts == 0);
}

TEST_CASE("A high model is tried on a smaller scale, with nearly the same contacts") {
  const auto table = [](float height) {
    return together({models::box({0, 0, height - 3}, {40, 40, height}),
                     models::box({0, 0, 0}, {3, 3, height}), models::box({37, 0, 0}, {40, 3, height}),
                     models::box({0, 37, 0}, {3, 40, height}), models::box({37, 37, 0}, {40, 40, height})});
  };
  const double low = tried(table(20)).figures.contacts, high = tried(table(80)).figures.contacts;
  CHECK(low > 50);
  CHECK(std::abs(high - low) < 0.2 * low);
  CHECK(std::abs(tried(table(80)).figures.largest_mm2 - 1600) < 40);  // half a pixel on each side
}

TEST_CASE("Scale applies to a trial") {
  CHECK(std::abs(
            tried(models::box({0, 0, 0}, {10, 10, 10}), {0, 0, 1}, {.scale = Scale(2)}).figures.largest_mm2 -
            400) < 5);
}

TEST_CASE("Columns that narrow below a block are its supports, but legs are not") {
  CHECK(tried(block_on_rods(0.2)).own_supports);
  CHECK_FALSE(tried(block_on_rods(0.6)).own_supports);
  CHECK_FALSE(tried(block_on_rods(0.2), {0, 0, -1}).own_supports);
}

TEST_CASE("A soup of facets that cross each other is not tried") {
  models::Facets soup;
  for (int i = 0; i < 3000; ++i) {
    const auto x = static_cast<float>(std::fmod(i * 7.31, 20.0)),
               y = static_cast<float>(std::fmod(i * 3.77, 20.0));
    soup.push_back({{{{x, 0, 0}, {y, 20, 0}, {10, 10, 20}}}});
  }
  CHECK_FALSE(tried(soup).figures.tried);
}
