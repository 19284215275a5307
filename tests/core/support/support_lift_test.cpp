#include "core/support/support_lift.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

constexpr Nanometers kLayer{50'000};

Nanometers lift_of(const models::Facets& facets, Nanometers layer = kLayer) {
  return support_lift(HeightIndex(facets), {}, layer);
}

// Returns the model, tilted so that it rises along x.
models::Facets tilted(models::Facets facets, float rise_for_each_mm) {
  for (Facet& facet : facets) {
    for (Vertex& vertex : facet.vertices)
      vertex.z += rise_for_each_mm * vertex.x;
  }
  return facets;
}

}  // namespace

TEST_CASE("A model that stands on a flat face stays on the plate") {
  CHECK(lift_of(models::box({0, 0, 3}, {10, 10, 20})) == Nanometers{});
  CHECK(lift_of(models::cone(5, 10, 40)) == Nanometers{});
}

TEST_CASE("A model that stands on a point or a round belly is lifted by 5 mm") {
  CHECK(lift_of(models::globe(10, 60, 120)) == Nanometers{5'000'000});
  const std::array<Point, 3> on_its_point{{{0, 0}, {5, 10}, {0, 10}}};
  CHECK(lift_of(models::lathe(on_its_point, 40)) == Nanometers{5'000'000});
}

TEST_CASE("A face holds the model from a tenth of the widest layer on") {
  const auto on_a_stem = [](float side) {
    return together(models::box({-side / 2, -side / 2, 0}, {side / 2, side / 2, 5}),
                    models::box({-10, -10, 5}, {10, 10, 8}));
  };
  CHECK(lift_of(on_a_stem(6.2F)) > Nanometers{});   // face of 38 mm2, widest layer of 400 mm2
  CHECK(lift_of(on_a_stem(6.5F)) == Nanometers{});  // face of 42 mm2
}

TEST_CASE("A model that would tip over is lifted") {
  const auto gallows = [](float arm) {
    return together(models::box({0, 0, 0}, {6, 6, 20}), models::box({0, 0, 20}, {arm, 6, 24}));
  };
  CHECK(lift_of(gallows(10)) == Nanometers{});
  CHECK(lift_of(gallows(30)) > Nanometers{});
}

TEST_CASE("The lift is a whole number of layers, rounded up") {
  CHECK(lift_of(models::globe(10, 60, 120), Nanometers{30'000}) == Nanometers{5'010'000});
  CHECK(lift_of(models::globe(10, 60, 120), Nanometers{100'000}) == Nanometers{5'000'000});
}

TEST_CASE("A tilted base stays on the plate if it rises no higher than the gap that bottom layers close") {
  const std::array<Point, 4> profile{{{0, 0}, {25, 0}, {25, 4}, {0, 4}}};
  const auto disc = models::lathe(profile, 96);
  const auto lift_at = [&](float rise_mm, Millimeters closed_gap = Millimeters{0.25}) {
    SupportSettings settings;
    settings.closed_gap = closed_gap;
    return support_lift(HeightIndex(tilted(disc, rise_mm / 50)), settings, kLayer);
  };
  for (const float rise_mm : {0.01F, 0.05F, 0.1F, 0.2F, 0.28F}) {
    INFO(rise_mm << " mm");
    CHECK(lift_at(rise_mm) == Nanometers{});
  }
  CHECK(lift_at(1.7F) > Nanometers{});
  CHECK(lift_at(0.2F, Millimeters{}) > Nanometers{});
  CHECK(lift_of(tilted(models::box({-20, -3, 0}, {20, 3, 20}), 0.007F)) == Nanometers{});
}

TEST_CASE("A round belly is lifted even if bottom layers close the gap beneath much of it") {
  for (const double radius_mm : {1.0, 2.0, 4.0, 30.0}) {
    INFO(radius_mm << " mm");
    CHECK(lift_of(models::globe(radius_mm, 60, 120)) > Nanometers{});
  }
  auto log = models::lathe(std::array<Point, 4>{{{0, 0}, {10, 0}, {10, 60}, {0, 60}}}, 180);
  for (Facet& facet : log) {
    for (Vertex& vertex : facet.vertices)
      vertex = {vertex.z, vertex.y, -vertex.x};
  }
  CHECK(lift_of(log) > Nanometers{});
}

TEST_CASE("Bottom layers close a gap as high as they are, but at most 0.3 mm") {
  CHECK(closed_gap(5, Nanometers{50'000}).count() == testing::Approx(0.25));
  CHECK(closed_gap(0, Nanometers{50'000}) == Millimeters{});
  CHECK(closed_gap(1000, Nanometers{100'000}) == Millimeters{0.3});
}

TEST_CASE("A model that stands on three small feet stays on the plate, on points or two feet it does not") {
  const auto on_feet = [](int feet, double width_mm) {
    models::Facets all = models::box({-10, -10, 5}, {10, 10, 8});
    for (int i = 0; i < feet; ++i) {
      auto foot =
          models::lathe(std::array<Point, 4>{{{0, 0}, {width_mm / 2, 0}, {width_mm / 2, 6}, {0, 6}}}, 24);
      models::translate(foot, i % 2 == 0 ? -8.0F : 8.0F, i / 2 % 2 == 0 ? -8.0F : 8.0F,
                        0.02F * static_cast<float>(i));
      all = together(std::move(all), foot);
    }
    return all;
  };
  for (const double width_mm : {0.3, 1.0, 4.0})
    CHECK(lift_of(on_feet(4, width_mm)) == Nanometers{});
  CHECK(lift_of(on_feet(4, 0.1)) > Nanometers{});
  CHECK(lift_of(on_feet(2, 1.0)) > Nanometers{});
}
