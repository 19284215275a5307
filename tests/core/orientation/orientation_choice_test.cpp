#include "core/orientation/orientation_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/orientation/candidate_directions.hpp"
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

TEST_CASE("The same model gives the same choice every time", "[long]") {
  const models::Facets gyroid = models::gyroid_sphere(10, 6, 40);
  CHECK(chosen(gyroid).ranked == chosen(gyroid).ranked);
}

TEST_CASE("A large model takes a bounded number of steps", "[long]") {
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
  CHECK_FALSE(choice.chosen().tried);
}

TEST_CASE("Facets without area and a single facet are accepted") {
  const Vertex v{1, 1, 1};
  CHECK(chosen({{{v, v, v}}}).as_drawn());
  CHECK(chosen({{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}}).ranked.size() > 1);
}

namespace {

// Returns a disc with a post, and the same solid as two bodies, with the post sunk into the disc.
models::Facets disc_with_post() {
  return models::lathe(std::vector<Point>{{0, 0}, {15, 0}, {15, 4}, {6, 4}, {6, 24}, {0, 24}}, 64);
}
models::Facets disc_and_post(float sunk_mm) {
  models::Facets post =
      models::lathe(std::vector<Point>{{0, 0}, {6, 0}, {6, 20.0 + sunk_mm}, {0, 20.0 + sunk_mm}}, 64);
  models::translate(post, 0, 0, 4 - sunk_mm);
  return together(models::lathe(std::vector<Point>{{0, 0}, {15, 0}, {15, 4}, {0, 4}}, 64), post);
}

// Returns a plate that stands on its supports, on a raft: 25 pillars that narrow to tips.
models::Facets plate_on_its_supports() {
  models::Facets model =
      together(models::box({0, 0, 0}, {30, 30, 1}), models::box({2, 2, 5.8F}, {28, 28, 8}));
  const Point profile[]{{0, 0}, {0.6, 0}, {0.6, 4}, {0.2, 5}, {0.2, 5.2}, {0, 5.2}};
  for (int i = 0; i < 25; ++i) {
    models::Facets pillar = models::lathe(profile, 16);
    models::translate(pillar, 5 + 5 * static_cast<float>(i % 5), 5 + 5 * static_cast<float>(i / 5), 0.8F);
    model = together(model, pillar);
  }
  return model;
}

}  // namespace

TEST_CASE("A model of bodies that touch or overlap is chosen like the same solid in one body") {
  const OrientationChoice one = chosen(disc_with_post());
  CHECK(one.as_drawn());
  for (const float sunk_mm : {0.0F, 0.5F, 4.0F}) {
    INFO(sunk_mm);
    const OrientationChoice two = chosen(disc_and_post(sunk_mm));
    CHECK(two.as_drawn());
    CHECK(two.chosen().contacts == 0);
    CHECK(std::abs(two.chosen().largest_mm2 - one.chosen().largest_mm2) < 1);
    models::Facets leaning = disc_and_post(sunk_mm);
    orient(leaning, {.up = Direction{1, 2, -1}});
    const OrientationChoice stood_up = chosen(leaning);
    CHECK(stood_up.chosen().contacts == 0);
    CHECK(std::abs(stood_up.chosen().size_z_mm - 24) < 0.01);  // float's rounding
  }
}

TEST_CASE("A base that is drawn nearly level is put flat on the plate") {
  const models::Facets disc = models::lathe(std::vector<Point>{{0, 0}, {25, 0}, {25, 4}, {0, 4}}, 64);
  for (const double tilt_deg : {0.01, 0.06, 0.4, 1.0, 2.0, 5.0}) {
    models::Facets tilted = disc;
    orient(tilted, {.y_deg = tilt_deg});
    const OrientationFigures best = chosen(tilted).chosen();
    INFO(tilt_deg);
    CHECK(std::abs(best.size_z_mm - 4) < 0.001);
    CHECK(best.up.z > 0.99);
    CHECK(best.contacts == 0);
    CHECK(best.stands);
  }
}

TEST_CASE("A base that is drawn nearly level is put flat also if it is the widest layer") {
  const models::Facets bowl = models::lathe(std::vector<Point>{{0, 0}, {10, 0}, {3, 12}, {0, 12}}, 32);
  for (const double tilt_deg : {0.1, 0.3, 0.6, 1.0, 3.0}) {
    models::Facets tilted = bowl;
    orient(tilted, {.x_deg = tilt_deg, .z_deg = -44});
    const OrientationFigures best = chosen(tilted).chosen();
    INFO(tilt_deg);
    CHECK(std::abs(best.size_z_mm - 12) < 0.001);
    CHECK(best.up.z > 0.99);
    CHECK(best.contacts == 0);
  }
  // The second face of its underside is nearly level, but the model lies on the first one.
  models::Facets roof = models::box({0, 0, 0}, {20, 20, 10});
  for (Facet& facet : roof)
    for (Vertex& v : facet.vertices)
      if (v.x == 20 && v.z == 0) v.z = 0.2F;
  const models::Facets keel = together(models::box({-20, 0, 0}, {0, 20, 10}), roof);
  CHECK(chosen(keel).as_drawn());
}

TEST_CASE("Bodies sunk into each other are laid flat whichever way they are drawn") {
  models::Facets table = models::box({0, 0, 6}, {24, 24, 12});
  for (const auto& [x, y] : {std::pair{5.0F, 5.0F}, std::pair{19.0F, 5.0F}, std::pair{11.0F, 19.0F}}) {
    models::Facets leg = models::lathe(std::vector<Point>{{0, 0}, {3, 0}, {3, 6.1}, {0, 6.1}}, 24);
    models::translate(leg, x, y, 0);
    table = together(table, leg);
  }
  for (const double tilt_deg : {0.0, 0.01, 0.05, 0.3, 1.0, 3.0, 30.0, 110.0}) {
    models::Facets tilted = table;
    orient(tilted, {.z_deg = 20});
    orient(tilted, {.x_deg = tilt_deg});
    const OrientationFigures best = chosen(tilted).chosen();
    INFO(tilt_deg);
    CHECK(best.contacts == 0);
    CHECK(std::abs(best.size_z_mm - 12) < 0.01);
  }
}

TEST_CASE("A model that carries supports in its file stays as drawn", "[long]") {
  for (const OrientationPreset preset :
       {OrientationPreset::Auto, OrientationPreset::Fast, OrientationPreset::Clean}) {
    const OrientationChoice choice = chosen(plate_on_its_supports(), {}, preset);
    CHECK(choice.own_supports);
    CHECK(choice.as_drawn());
  }
  CHECK_FALSE(chosen(large_table()).own_supports);
  OrientationRequest overruling;
  overruling.keep_own_supports = false;
  CHECK_FALSE(choose_orientation(plate_on_its_supports(), overruling).value().own_supports);
}

TEST_CASE("The contacts of the best directions are those that the layers show") {
  const OrientationChoice choice = chosen(large_table());
  const auto drawn = std::ranges::find(choice.ranked, Direction{0, 0, 1}, &OrientationFigures::up);
  CHECK(drawn->tried);
  CHECK(choice.chosen().tried);
  CHECK(drawn->contacts > 50);                               // 1600 mm2, of which one contact holds 11.1 mm2
  CHECK(std::abs(choice.chosen().largest_mm2 - 1600) < 20);  // a row of pixels on each side
}
