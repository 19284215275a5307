#include "core/overhangs/carried_supports.hpp"

#include <cmath>
#include <stop_token>

#include "core/routing/support_layout.hpp"
#include "core/support/support_mesh.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using models::together;

namespace {

bool carries(const models::Facets& facets, const std::stop_token& stop = {}) {
  return carries_supports(std::make_shared<const HeightIndex>(facets), {}, stop);
}

struct Pillar {
  double foot_mm = 3, pillar_mm = 1, tip_mm = 0.4, height_mm = 5;
};

models::Facets pillar_at(float x, float y, const Pillar& pillar) {
  const double foot = pillar.foot_mm / 2, shaft = pillar.pillar_mm / 2, tip = pillar.tip_mm / 2;
  const double top = pillar.height_mm;
  models::Facets facets = models::lathe(
      std::array<Point, 7>{
          {{0, 0}, {foot, 0}, {shaft, 1}, {shaft, top - 1}, {tip, top}, {tip, top + 0.2}, {0, top + 0.2}}},
      24);
  models::translate(facets, x, y, 0);
  return facets;
}

models::Facets at(models::Facets facets, float x, float y) {
  models::translate(facets, x, y, 0);
  return facets;
}

// Returns a plate of 20 by 20 mm on pillars that are 5 mm apart. All but one of them begin `uneven_mm` above
// the plate.
models::Facets plate_on(const Pillar& pillar, float uneven_mm = 0) {
  const auto height = static_cast<float>(pillar.height_mm);
  models::Facets all = models::box({-10, -10, height}, {10, 10, height + 3});
  for (int i = 0; i < 25; ++i) {
    const auto x = static_cast<float>(4.8 * (i % 5 - 2)), y = static_cast<float>(4.8 * (i / 5 - 2));
    auto one = pillar_at(x, y, pillar);
    models::translate(one, 0, 0, i == 0 ? 0 : uneven_mm);
    all = together(std::move(all), one);
  }
  return all;
}

// Returns a plate of 20 by 20 mm on 25 long cones with a ball at the end of each.
models::Facets plate_on_balls(double cone_mm, double ball_mm) {
  const double top = 2 + cone_mm, ball = ball_mm / 2, neck = 0.6 * ball;
  const std::array<Point, 8> profile{{{0, 0},
                                      {0.6, 0},
                                      {0.6, 2},
                                      {neck, top},
                                      {ball, top + ball},
                                      {ball, top + 1.2 * ball},
                                      {neck, top + 2 * ball},
                                      {0, top + 2 * ball}}};
  const auto under = static_cast<float>(top + 1.6 * ball);
  models::Facets all = models::box({-10, -10, under}, {10, 10, under + 3});
  for (int i = 0; i < 25; ++i) {
    auto one = models::lathe(profile, 24);
    models::translate(one, static_cast<float>(4.8 * (i % 5 - 2)), static_cast<float>(4.8 * (i / 5 - 2)), 0);
    all = together(std::move(all), one);
  }
  return all;
}

// Returns a post with an arm 15 mm above the plate, which `tips` pillars hold.
models::Facets arm_on(int tips) {
  auto all = together(models::box({-5, -5, 0}, {5, 5, 30}), models::box({4, -5, 15}, {40, 5, 20}));
  for (int i = 0; i < tips; ++i)
    all = together(all, pillar_at(static_cast<float>(8 + 5 * (i % 7)), static_cast<float>(-3 + 6 * (i / 7)),
                                  {2, 1, 0.4, 15}));
  return all;
}

}  // namespace

TEST_CASE("A plate on pointed pillars carries supports, whatever their feet and tips") {
  for (const Pillar& pillar :
       {Pillar{}, Pillar{0.3, 0.3, 0.2}, Pillar{1, 1, 0.4}, Pillar{4, 1.5, 0.8}, Pillar{3, 1, 0.2, 12}}) {
    INFO(pillar.foot_mm << " mm feet, " << pillar.tip_mm << " mm tips");
    CHECK(carries(plate_on(pillar)));
  }
  CHECK(carries(plate_on({}, 0.05F)));
  CHECK(carries(plate_on({}, 0.2F)));
  CHECK(carries(together(plate_on({}), models::box({-12, -12, 0}, {12, 12, 1}))));  // on a raft
}

TEST_CASE("Balls at the ends of long cones are tips") {
  for (const double cone_mm : {2.0, 6.0, 12.0, 20.0}) {
    for (const double ball_mm : {0.4, 0.6, 0.8}) {
      INFO("cones of " << cone_mm << " mm, balls of " << ball_mm << " mm");
      CHECK(carries(plate_on_balls(cone_mm, ball_mm)));
    }
  }
}

TEST_CASE("Legs, struts and models without supports do not count as supports") {
  CHECK_FALSE(carries(models::box({0, 0, 0}, {10, 10, 10})));
  CHECK_FALSE(carries(models::globe(10, 40, 80)));
  CHECK_FALSE(carries(plate_on({1, 1, 1})));    // not pointed
  CHECK_FALSE(carries(plate_on({3, 3, 2.5})));  // thicker than a tip
  models::Facets chessmen;                      // with a waist
  for (int i = 0; i < 9; ++i) {
    const std::array<Point, 7> profile{
        {{0, 0}, {0.5, 0}, {0.5, 2}, {0.2, 3}, {0.8, 4.5}, {0.8, 12}, {0, 12}}};
    auto one = models::lathe(profile, 24);
    models::translate(one, static_cast<float>(4 * (i % 3)), static_cast<float>(4 * (i / 3)), 0);
    chessmen = together(std::move(chessmen), one);
  }
  CHECK_FALSE(carries(chessmen));
  models::Facets lattice;
  for (int i = 0; i < 5; ++i) {
    for (int k = 0; k < 5; ++k) {
      const auto a = static_cast<float>(4 * i), b = static_cast<float>(4 * k);
      lattice = together({std::move(lattice), models::box({a, b, 0}, {a + 0.8F, b + 0.8F, 16}),
                          models::box({0, a, b}, {16.8F, a + 0.8F, b + 0.8F}),
                          models::box({a, 0, b}, {a + 0.8F, 16.8F, b + 0.8F})});
    }
  }
  CHECK_FALSE(carries(lattice));
}

TEST_CASE("Columns that end flat beneath a roof are part of the model, whatever their feet") {
  // Columns with a plinth, tapered ones and ones with a capital.
  const std::vector<std::vector<Point>> columns{
      {{0, 0}, {0.5, 0}, {0.5, 15.2}, {0, 15.2}},
      {{0, 0}, {1, 0}, {1, 1}, {0.5, 1}, {0.5, 15.2}, {0, 15.2}},
      {{0, 0}, {0.9, 0}, {0.5, 3}, {0.5, 15.2}, {0, 15.2}},
      {{0, 0}, {0.6, 0}, {0.45, 15.2}, {0, 15.2}},
      {{0, 0}, {0.4, 0}, {0.4, 14.2}, {0.55, 14.5}, {0.55, 15.2}, {0, 15.2}},
      {{0, 0}, {1, 0}, {1, 0.5}, {0.45, 0.5}, {0.4, 14.2}, {0.55, 14.4}, {0.55, 15.2}, {0, 15.2}},
      {{0, 0}, {0.5, 0}, {0.5, 2}, {0.25, 14}, {0.4, 14.5}, {0.4, 15.2}, {0, 15.2}}};
  for (const std::vector<Point>& profile : columns) {
    INFO("foot of " << 2 * profile[1].x << " mm, " << profile.size() << " points");
    for (const int aside : {2, 3, 4}) {
      models::Facets carport = models::box({-7, -7, 15}, {7, 7, 17});
      for (int i = 0; i < aside * aside; ++i)
        carport = together(std::move(carport),
                           at(models::lathe(profile, 24),
                              12.0F / static_cast<float>(aside - 1) * static_cast<float>(i % aside) - 6,
                              12.0F / static_cast<float>(aside - 1) * static_cast<float>(i / aside) - 6));
      CHECK_FALSE(carries(carport));
    }
  }
}

TEST_CASE("Parasols on pointed poles are part of the model, alone or on one base") {
  const std::array<Point, 8> profile{
      {{0, 0}, {1.5, 0}, {1.5, 0.5}, {0.5, 1}, {0.5, 18}, {0.25, 20}, {2.5, 20}, {0, 22}}};
  models::Facets parasols;
  for (int i = 0; i < 9; ++i)
    parasols = together(std::move(parasols), at(models::lathe(profile, 24), static_cast<float>(8 * (i % 3)),
                                                static_cast<float>(8 * (i / 3))));
  CHECK_FALSE(carries(parasols));
  CHECK_FALSE(carries(together(parasols, models::box({-4, -4, -1}, {20, 20, 0.1F}))));
}

TEST_CASE("A tree whose branches end in its crown does not carry supports") {
  models::Facets tree = models::globe(9, 40, 80);
  models::translate(tree, 0, 0, 26);
  tree =
      together(std::move(tree), models::lathe(std::array<Point, 4>{{{0, 0}, {2, 0}, {1, 22}, {0, 22}}}, 24));
  for (int i = 0; i < 6; ++i) {
    models::Facets branch = models::lathe(std::array<Point, 4>{{{0, 0}, {0.7, 0}, {0.4, 16}, {0, 16}}}, 16);
    for (Facet& facet : branch) {
      for (Vertex& v : facet.vertices) {
        v.x += 0.4F * v.z * std::cos(static_cast<float>(i));
        v.y += 0.4F * v.z * std::sin(static_cast<float>(i));
        v.z += 8;
      }
    }
    tree = together(std::move(tree), branch);
  }
  CHECK_FALSE(carries(tree));
}

TEST_CASE("Supports that contourd made itself are recognised in a file") {
  models::Facets ball = models::globe(8, 40, 80);
  models::Facets ring = models::isosurface(
      [](double x, double y, double z) { return std::hypot(std::hypot(x, y) - 8, z) - 3; }, 12, 48);
  models::translate(ring, 0, 0, 3);
  for (models::Facets facets : {at(ball, 0, 0), ring, models::box({-9, -7, 0}, {9, 7, 4})}) {
    float low = 1e9F;
    for (const Facet& facet : facets)
      for (const Vertex& v : facet.vertices)
        low = std::min(low, v.z);
    models::translate(facets, 0, 0, 5 - low);
    const DisplayGeometry display{Pixels{800}, Pixels{800}, Micrometers{50.0}};
    for (const double tip_mm : {0.3, 0.4, 0.8}) {
      INFO(facets.size() << " facets, tips of " << tip_mm << " mm");
      SupportSettings settings;
      settings.tip_diameter = Millimeters{tip_mm};
      const StandingModel standing{std::make_shared<const HeightIndex>(facets),
                                   Elevation{Nanometers{5'000'000}}};
      const Supports supports =
          make_supports(
              {{PlateModel{standing, {PixelMap::true_scale(display, {0, 0})}}}, display, settings, {}, {}})
              .value();
      REQUIRE(supports.structure);
      CHECK(carries(together(facets, support_mesh(supports.structure->primitives()))));
      CHECK_FALSE(carries(facets));
    }
  }
}

TEST_CASE("A model carries supports only if they hold most of what has to be held") {
  CHECK(carries(arm_on(14)));
  CHECK_FALSE(carries(arm_on(2)));
  // Another plate, which would need more than a hundred contacts.
  CHECK_FALSE(carries(together(arm_on(7), models::box({-30, -30, 14}, {4, -4, 16}))));
}

TEST_CASE("A stopped search finds no supports") {
  std::stop_source source;
  source.request_stop();
  CHECK_FALSE(carries(plate_on({}), source.get_token()));
}
