#include "core/orientation/orientation_trial.hpp"

#include <cmath>

#include "core/orientation/orientation_rating.hpp"
#include "core/orientation/rated_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

OrientationFigures tried(const models::Facets& facets, const Direction& up = {0, 0, 1},
                         const OrientationRequest& request = {}) {
  const RatedMesh mesh({.facets = facets, .cell_mm = kContactCellMm});
  return try_orientation(facets, OrientationRating(mesh, request, OrientationRating::Mesh::Whole).rate(up),
                         request);
}

}  // namespace

TEST_CASE("A trial finds a cone on its point held and lifted, and on its base neither") {
  const OrientationFigures on_point = tried(models::cone(5, 20, 48), {0, 0, -1});
  CHECK(on_point.tried);
  CHECK_FALSE(on_point.stands);
  CHECK(on_point.contacts > 0);
  // Each support is at least as high as the lift.
  CHECK(on_point.support_mm3 >= on_point.contacts * pillar_mm3(5));
  const OrientationFigures on_base = tried(models::cone(5, 20, 48));
  CHECK(on_base.stands);
  CHECK(on_base.contacts == 0);
}

TEST_CASE("A high model is tried on a smaller scale, with nearly the same contacts") {
  const auto table = [](float height) {
    return together({models::box({0, 0, height - 3}, {40, 40, height}),
                     models::box({0, 0, 0}, {3, 3, height}), models::box({37, 0, 0}, {40, 3, height}),
                     models::box({0, 37, 0}, {3, 40, height}), models::box({37, 37, 0}, {40, 40, height})});
  };
  const double low = tried(table(20)).contacts, high = tried(table(80)).contacts;
  CHECK(low > 50);
  CHECK(std::abs(high - low) < 0.2 * low);
  CHECK(std::abs(tried(table(80)).largest_mm2 - 1600) < 40);  // half a pixel on each side
}

TEST_CASE("Scale applies to a trial") {
  CHECK(std::abs(tried(models::box({0, 0, 0}, {10, 10, 10}), {0, 0, 1}, {.scale = Scale(2)}).largest_mm2 -
                 400) < 5);
}

TEST_CASE(
    "A model whose base rises beyond the closed gap does not stand, however small its trial's scale is") {
  for (const float height_mm : {20.0F, 200.0F}) {
    INFO(height_mm);
    models::Facets tilted = models::box({0, 0, 0}, {20, 20, height_mm});
    orient(tilted, {.y_deg = 2});  // the base rises by 0.7 mm
    CHECK_FALSE(tried(tilted).stands);
  }
}

TEST_CASE("A soup of facets that cross each other is not tried") {
  models::Facets soup;
  for (int i = 0; i < 3000; ++i) {
    const auto x = static_cast<float>(std::fmod(i * 7.31, 20.0)),
               y = static_cast<float>(std::fmod(i * 3.77, 20.0));
    soup.push_back({{{{x, 0, 0}, {y, 20, 0}, {10, 10, 20}}}});
  }
  CHECK_FALSE(tried(soup).tried);
}
