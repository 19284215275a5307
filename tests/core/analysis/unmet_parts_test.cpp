#include "core/analysis/unmet_parts.hpp"

#include "core/layers/layers.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/near.hpp"

using models::together;

namespace {

constexpr Nanometers kLayer{50'000};
constexpr double kLeastMm2 = 0.1;

std::vector<UnmetPart> unmet(const models::Facets& facets, Nanometers layer = kLayer) {
  const PlateModel model = plate_model(facets);
  const LayerStack stack = layers_for(model.top(), layer);
  const std::vector<Nanometers> all(static_cast<std::size_t>(stack.count), layer);
  return find_unmet_parts(model, kCoarseDisplay, middles_of(all), kLeastMm2, 60s);
}

const models::Facets kColumn = models::box({-1, -1, 0}, {1, 1, 6});

}  // namespace

TEST_CASE("A plate between two cuts is found with its place, thickness and area") {
  const models::Facets plate = models::box({-3, -4, 2.0F}, {3, 4, 2.02F});
  const std::vector<UnmetPart> parts = unmet(together(kColumn, plate));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].height == Nanometers{2'010'000});
  CHECK(near(parts[0].thickness.count(), 0.02, 1e-6));
  CHECK(near(parts[0].area_mm2, 6 * 8 - 2 * 2, 1e-9));
  // The first pixel of the highest row.
  CHECK(near(parts[0].plate_mm.x, -2.95));
  CHECK(near(parts[0].plate_mm.y, 3.95));
}

TEST_CASE("A plate that a cut meets is printed") {
  CHECK(unmet(together(kColumn, models::box({-3, -4, 2.01F}, {3, 4, 2.03F}))).empty());
  CHECK(unmet(together(kColumn, models::box({-3, -4, 2.0F}, {3, 4, 2.02F})), Nanometers{20'000}).empty());
  CHECK(unmet(together(kColumn, models::box({-3, -4, 2.0F}, {3, 4, 2.06F}))).empty());
}

TEST_CASE("Plates at several heights are found from the plate up, on the build plate and at the top, too") {
  const std::vector<UnmetPart> parts =
      unmet(together({kColumn, models::box({-3, -4, 3.03F}, {3, 4, 3.05F}),
                      models::box({-3, -4, 0}, {3, 4, 0.02F}), models::box({-3, -4, 6}, {3, 4, 6.02F})}));
  REQUIRE(parts.size() == 3);
  CHECK(parts[0].height == Nanometers{10'000});
  CHECK(near(in_mm(parts[1].height), 3.04, 1e-6));
  CHECK(near(in_mm(parts[2].height), 6.01, 1e-6));
}

TEST_CASE("A fin of one body with its model is found") {
  const std::vector<Point> profile{{0, 0}, {1, 0}, {1, 2.0}, {3, 2.0}, {3, 2.02}, {1, 2.02}, {1, 4}, {0, 4}};
  const std::vector<UnmetPart> parts = unmet(models::lathe(profile, 60));
  REQUIRE(parts.size() == 1);
  CHECK(near(parts[0].area_mm2, 8 * 3.14159, 0.5));
}

TEST_CASE("A thin plate in front of a large face at the same height is found") {
  const models::Facets overhang = models::box({-9, -9, 1.99F}, {-4, 9, 5});
  const std::vector<UnmetPart> parts = unmet(together(
      {models::box({-9, -9, 0}, {-4, 9, 1.98F}), models::box({2, -4, 1.985F}, {4, 4, 2.02F}), overhang}));
  REQUIRE(parts.size() == 1);
  CHECK(near(parts[0].area_mm2, 16, 1e-9));
}

TEST_CASE("Models without thin parts have none: walls, ledges, slits, balls") {
  CHECK(unmet({}).empty());
  CHECK(unmet(models::box({-3, -4, 0}, {3, 4, 0.02F})).empty());  // too thin for any layer
  CHECK(unmet(kColumn).empty());
  CHECK(unmet(models::globe(4, 60, 60)).empty());
  CHECK(unmet(models::gyroid_sphere(8, 5, 24)).empty());
  // A slit between two solids, and a ledge below an overhang between the same cuts.
  CHECK(unmet(together(models::box({-3, -4, 0}, {3, 4, 2.0F}), models::box({-3, -4, 2.02F}, {3, 4, 5})))
            .empty());
  CHECK(unmet(together(
                  {kColumn, models::box({2, 0, 0}, {4, 4, 2.02F}), models::box({-4, 0, 2.0F}, {-2, 4, 6})}))
            .empty());
}

TEST_CASE("Of many plates only some are looked for") {
  models::Facets many = kColumn;
  for (int i = 0; i < 40; ++i) {
    const float z = 1 + 0.1F * static_cast<float>(i);
    many = together(many, models::box({-3, -4, z + 0.002F}, {3, 4, z + 0.02F}));
  }
  CHECK(unmet(many).size() == 16);
}
