#include "core/orientation/orientation_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/orientation/rated_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

OrientationChoice chosen(const models::Facets& facets, OrientationRequest request = {},
                         OrientationPreset preset = OrientationPreset::Auto) {
  request.weights = weights_of(preset, request.weights);
  return choose_orientation(facets, request).value();
}

models::Facets large_table() {
  return together({models::box({0, 0, 20}, {40, 40, 23}), models::box({0, 0, 0}, {3, 3, 23}),
                   models::box({37, 0, 0}, {40, 3, 23}), models::box({0, 37, 0}, {3, 40, 23}),
                   models::box({37, 37, 0}, {40, 40, 23})});
}

}  // namespace

TEST_CASE("A cube stays as it is drawn") {
  const models::Facets cube = models::box({0, 0, 0}, {20, 20, 20});
  for (const OrientationPreset preset :
       {OrientationPreset::Auto, OrientationPreset::Fast, OrientationPreset::Clean, OrientationPreset::Safe})
    CHECK(chosen(cube, {}, preset).as_drawn());
}

TEST_CASE("A ball, which is the same from everywhere, stays as it is drawn") {
  CHECK(chosen(models::sphere(10, 30)).as_drawn());
}

TEST_CASE("A ball with a flat face stands on that face, however it is drawn") {
  const Point profile[]{{0, 0}, {6, 0}, {8, 2}, {10, 8}, {9, 13}, {5, 17}, {0, 18}};
  models::Facets ball = models::lathe(profile, 64);
  CHECK(chosen(ball).as_drawn());
  orient(ball, {.up = Direction{1, 1, -1}});
  const OrientationChoice choice = chosen(ball);
  CHECK(choice.chosen().stands);
  CHECK(choice.chosen().contacts == 0);
  CHECK(std::abs(choice.chosen().size_z_mm - 18) < 0.01);  // float's rounding
}

TEST_CASE("A table on its legs is turned upside down") {
  const OrientationChoice choice = chosen(large_table());
  CHECK(choice.chosen().up == Direction{0, 0, -1});
  CHECK(choice.chosen().contacts == 0);
}

TEST_CASE("An L lies or stands so that nothing hangs over") {
  // Drawn upside down: its long arm sticks out at the top.
  const models::Facets angle =
      together({models::box({0, 0, 0}, {5, 10, 30}), models::box({5, 0, 25}, {40, 10, 30})});
  const OrientationChoice choice = chosen(angle);
  CHECK_FALSE(choice.as_drawn());
  CHECK(choice.chosen().contacts == 0);
  CHECK(choice.chosen().stands);
}

TEST_CASE("A tall thin cone stands on its base") {
  models::Facets cone = models::cone(5, 60, 48);
  CHECK(chosen(cone).as_drawn());
  orient(cone, {.up = Direction{0, 0, -1}});
  CHECK(chosen(cone).chosen().up == Direction{0, 0, -1});
}

TEST_CASE("A flat plate on edge prints well and stays, but lies down for a fast print") {
  const models::Facets plate = models::box({0, 0, 0}, {40, 3, 40});
  CHECK(chosen(plate).as_drawn());
  CHECK(chosen(plate, {}, OrientationPreset::Safe).as_drawn());
  const OrientationChoice fast = chosen(plate, {}, OrientationPreset::Fast);
  CHECK(std::abs(fast.chosen().size_z_mm - 3) < 1e-6);  // rounding
}

TEST_CASE("A model that is too high for the machine is laid down") {
  const models::Facets column = models::lathe(std::vector<Point>{{0, 0}, {5, 0}, {5, 100}, {0, 100}}, 48);
  CHECK(chosen(column).as_drawn());
  const OrientationRequest low{.build = BuildSize{Millimeters{120}, Millimeters{60}, Millimeters{80}}};
  const OrientationChoice choice = chosen(column, low);
  CHECK(choice.chosen().fits);
  CHECK_FALSE(choice.as_drawn());
  CHECK(choice.chosen().size_z_mm <= 80);
}

TEST_CASE("A model that fits in no orientation stays as drawn unless another one is better") {
  const OrientationRequest tiny{.build = BuildSize{Millimeters{1}, Millimeters{1}, Millimeters{1}}};
  const OrientationChoice choice = chosen(models::box({0, 0, 0}, {20, 20, 20}), tiny);
  CHECK(choice.as_drawn());
  CHECK_FALSE(choice.chosen().fits);
}

TEST_CASE("A face that is to be kept clean is neither on the plate nor supported") {
  OrientationRequest request;
  request.keep_clean = {Direction{0, 0, -1}};
  const OrientationChoice choice = chosen(models::box({0, 0, 0}, {30, 30, 10}), request);
  CHECK_FALSE(choice.as_drawn());
  CHECK(choice.chosen().touched_mm2 == 0);
  CHECK(choice.chosen().contacts == 0);
  request.keep_clean = {KeepCleanBox{{-1, -1, -1}, {31, 31, 1}}};
  CHECK(chosen(models::box({0, 0, 0}, {30, 30, 10}), request).chosen().touched_mm2 == 0);
}

TEST_CASE("An inside-out model is turned like the same model the right way out") {
  models::Facets facets = large_table();
  models::invert(facets);
  CHECK(chosen(facets).chosen() == chosen(large_table()).chosen());
}

TEST_CASE("The alternatives are ranked, with the model as it is drawn among them") {
  const OrientationChoice choice = chosen(large_table());
  REQUIRE(choice.ranked.size() > 5);
  CHECK(std::ranges::is_sorted(choice.ranked, {}, &OrientationFigures::score));
  CHECK(std::ranges::count(choice.ranked, Direction{0, 0, 1}, &OrientationFigures::up) == 1);
  CHECK(choice.tried <= kMostDirections);
}

TEST_CASE("The same model gives the same choice every time") {
  const models::Facets gyroid = models::gyroid_sphere(10, 6, 40);
  CHECK(chosen(gyroid).ranked == chosen(gyroid).ranked);
}

TEST_CASE("A large model takes a bounded number of steps") {
  const models::Facets ball = models::sphere(20, 200);
  REQUIRE(ball.size() > 200'000);
  const OrientationChoice choice = chosen(ball);
  // Facets rated, and the heights of facets that span several: few if facets are small.
  const std::uint64_t rated = kMostDirections * kSampledFacets + finalists_of(ball.size()) * ball.size();
  CHECK(choice.steps < 2 * rated);
  CHECK(finalists_of(1) == 24);
  CHECK(finalists_of(1'000'000) == 8);
  CHECK(finalists_of(1'000'000'000) == 6);
}

TEST_CASE("Facets that span all heights take a bounded number of steps") {
  models::Facets slivers;
  for (int i = 0; i < 60'000; ++i) {
    const float x = static_cast<float>(i % 300), y = static_cast<float>(i / 300);
    slivers.push_back({{{{x, y, 0}, {x + 0.1F, y, 0}, {x, y + 0.1F, 50}}}});
  }
  const OrientationChoice choice = chosen(slivers);
  CHECK(choice.steps < 130 * (kMostDirections * kSampledFacets + 24 * slivers.size()));
}

TEST_CASE("Choosing stops soon when a stop is requested") {
  std::stop_source stop;
  stop.request_stop();
  CHECK_FALSE(choose_orientation(models::box({0, 0, 0}, {1, 1, 1}), {}, stop.get_token()).has_value());
}

TEST_CASE("A model with the largest coordinates is rated") {
  const float most = std::numeric_limits<float>::max();
  const OrientationChoice choice = chosen(models::box({-most, -most, -most}, {most, most, most}));
  CHECK(choice.as_drawn());
  CHECK(std::isfinite(choice.chosen().score));
}

TEST_CASE("Facets without area and a single facet are accepted") {
  const Vertex v{1, 1, 1};
  CHECK(chosen({{{v, v, v}}}).as_drawn());
  CHECK(chosen({{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}}).ranked.size() > 1);
}
