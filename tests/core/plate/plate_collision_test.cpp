#include "core/plate/plate_collision.hpp"

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

const DisplayGeometry kPlateDisplay{Pixels{200}, Pixels{160}, Micrometers{100.0}};

PlacedModel placed(const models::Facets& facets, Point center, Elevation elevation = {}) {
  return {{std::make_shared<const HeightIndex>(facets), elevation}, center};
}

// Returns a block of 12 x 12 x 5 mm with a hole of 8 x 8 mm.
models::Facets ring() {
  return models::together(models::box({0, 0, 0}, {12, 12, 5}),
                          models::inverted(models::box({2, 2, 0}, {10, 10, 5})));
}

}  // namespace

TEST_CASE("A pin stands in a ring without touching it, and touches it when it is moved or wide") {
  const models::Facets pin = models::box({50, 50, 50}, {54, 54, 60});
  CHECK(bounds_overlap(placed(ring(), {1, 1}), placed(pin, {1, 1})));
  CHECK_FALSE(find_collision(placed(ring(), {1, 1}), placed(pin, {1, 1}), kPlateDisplay, kCoarseLayer));
  // 2 mm to the right the pin touches the ring's wall; a pixel more, and it stands in the wall.
  CHECK_FALSE(find_collision(placed(ring(), {1, 1}), placed(pin, {3, 1}), kPlateDisplay, kCoarseLayer));
  const auto collision =
      find_collision(placed(ring(), {1, 1}), placed(pin, {3.1, 1}), kPlateDisplay, kCoarseLayer);
  REQUIRE(collision);
  CHECK(collision->height == kCoarseLayer / 2);
  CHECK(std::fabs(collision->place.x - 5.05) < 1e-9);
  CHECK(std::fabs(collision->place.y - 2.95) < 1e-9);
}

TEST_CASE("Models that meet high above the plate collide at that height") {
  const models::Facets mushroom =
      models::together(models::box({4, 4, 0}, {6, 6, 3}), models::box({0, 0, 3}, {10, 10, 4}));
  const models::Facets low = models::box({0, 0, 0}, {3, 3, 2.9F}),
                       high = models::box({0, 0, 0}, {3, 3, 3.3F});
  CHECK_FALSE(find_collision(placed(mushroom, {0, 0}), placed(low, {-3, 3}), kPlateDisplay, kCoarseLayer));
  const auto collision =
      find_collision(placed(mushroom, {0, 0}), placed(high, {-3, 3}), kPlateDisplay, kCoarseLayer);
  REQUIRE(collision);
  CHECK(collision->height == Nanometers{3'050'000});
  CHECK(std::fabs(collision->place.x + 4.45) < 1e-9);
  CHECK(std::fabs(collision->place.y - 4.45) < 1e-9);
}

TEST_CASE(
    "A model that stands above the plate collides at the height where it is, or stands above the other") {
  const models::Facets cube = models::box({0, 0, 7}, {3, 3, 10}), taller = models::box({0, 0, 0}, {3, 3, 8});
  const Elevation raised(Nanometers{5'000'000});
  CHECK_FALSE(
      find_collision(placed(cube, {0, 0}), placed(cube, {0, 0}, raised), kPlateDisplay, kCoarseLayer));
  for (const bool raised_first : {false, true}) {
    const PlacedModel above = placed(cube, {0, 0}, raised), below = placed(taller, {1, 0});
    const auto collision = raised_first ? find_collision(above, below, kPlateDisplay, kCoarseLayer)
                                        : find_collision(below, above, kPlateDisplay, kCoarseLayer);
    REQUIRE(collision);
    CHECK(collision->height == Nanometers{5'050'000});
  }
  const auto alike =
      find_collision(placed(cube, {0, 0}, raised), placed(cube, {0, 0}, raised), kPlateDisplay, kCoarseLayer);
  REQUIRE(alike);
  CHECK(alike->height == Nanometers{5'050'000});
}

TEST_CASE("Boxes that share a wall do not collide") {
  const models::Facets cube = models::box({0, 0, 0}, {3, 3, 3});
  CHECK_FALSE(bounds_overlap(placed(cube, {-1.5, 0}), placed(cube, {1.5, 0})));
  CHECK_FALSE(find_collision(placed(cube, {-1.5, 0}), placed(cube, {1.5, 0}), kPlateDisplay, kCoarseLayer));
  CHECK_FALSE(find_collision(placed(cube, {-30, 0}), placed(cube, {30, 0}), kPlateDisplay, kCoarseLayer));
}

TEST_CASE("A collision is found exactly where both single masks are lit, wherever the models stand") {
  const models::Facets ball = models::sphere(3, 24), post = models::box({0, 0, 0}, {2.5F, 1.5F, 7});
  CHECK(rc::check([&] {
    const auto place = [] { return Point{testing::draw_real(-11, 11), testing::draw_real(-9, 9)}; };
    const PlacedModel a = placed(ball, place()), b = placed(post, place());
    const auto engine_for = [](const PlacedModel& model) {
      const Point middle = model.model->bounds().center();
      return ContourEngine(
          {PlateModel{
              {model.model},
              {PixelMap::true_scale(kPlateDisplay, {middle.x - model.center.x, middle.y - model.center.y})}}},
          EngineSettings{kPlateDisplay, AntiAliasing::On});
    };
    ContourEngine one = engine_for(a), other = engine_for(b);
    std::int64_t lowest_um = -1;
    for (std::int64_t um = 50; um < 6'000 && lowest_um < 0; um += 100) {
      const Nanometers height{um * 1000};
      const auto lit = one.mask_at(height).pixels(), lit_too = other.mask_at(height).pixels();
      for (std::size_t i = 0; i < lit.size(); ++i) {
        if (lit[i] != 0 && lit_too[i] != 0) lowest_um = um;
      }
    }
    const auto collision = find_collision(a, b, kPlateDisplay, kCoarseLayer);
    // Parts that share a pixel without overlapping are not compared.
    RC_ASSERT(collision.has_value() == (lowest_um >= 0 && bounds_overlap(a, b)));
    if (collision) RC_ASSERT(collision->height == Nanometers{lowest_um * 1000});
  }));
}
