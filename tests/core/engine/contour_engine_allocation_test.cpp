// Checks the promise "Allocates nothing once it has seen its largest section".

#include "core/analysis/island_finder.hpp"
#include "core/analysis/void_finder.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/mask_runs.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/warm_allocations.hpp"
#include "tests/models/models.hpp"

namespace {

// Returns the allocations of a second pass over all layers.
long engine_allocations(models::Facets facets, EngineSettings settings = {}) {
  settings.display = kFineDisplay;
  const auto model = std::make_shared<const HeightIndex>(std::move(facets));
  const PixelMap map = PixelMap::true_scale(settings.display, {0, 0});
  ContourEngine engine(std::vector<PlateModel>{{{model}, {map}}, {{model}, {map, map}}}, settings);
  return allocations_when_warm(2, [&engine] {
    for (Nanometers height{0}; height < mm(20); height += kThickLayer) {
      (void)engine.mask_at(height);
      (void)engine.count_loops();
      (void)engine.contours_at(height);
    }
  });
}

}  // namespace

TEST_CASE("Allocations are counted") {
  const long before = testing::allocations();
  const std::vector<int> memory(1000);
  CHECK(testing::allocations() > before);
}

TEST_CASE("A warm engine allocates nothing for a sound model") {
  CHECK(engine_allocations(models::gyroid_sphere(10, 6, 24)) == 0);
}

TEST_CASE("A warm engine allocates nothing for a cracked model") {
  models::Facets facets = models::gyroid_sphere(10, 6, 24);
  for (std::size_t i = 0; i < facets.size(); i += 100)
    facets[i] = facets.back();
  CHECK(engine_allocations(facets) == 0);
}

TEST_CASE("A warm engine allocates nothing for a duplicated model") {
  models::Facets facets = models::gyroid_sphere(10, 6, 24);
  CHECK(engine_allocations(models::together(facets, facets)) == 0);
}

TEST_CASE("Finding voids allocates nothing when warm") {
  ContourEngine engine = engine_for(models::gyroid_sphere(10, 6, 24));
  MaskRuns solid;
  VoidFinder finder;
  CHECK(allocations_when_warm(3, [&] {
          for (std::int32_t layer = 0; kThickLayer * layer < Nanometers{20'250'000}; ++layer) {
            solid.extract(engine.mask_at(kThickLayer * layer));
            (void)finder.add_layer(solid, {layer, kThickLayer});
          }
          (void)finder.end();
        }) == 0);
}

TEST_CASE("Finding islands allocates nothing when warm") {
  ContourEngine engine = engine_for(models::gyroid_sphere(10, 6, 24));
  // Runs alternate between two layers, as in an analysis: both must have seen the largest.
  MaskRuns lit, bright, beneath;
  lit.extract(engine.coverage());
  bright.extract_bright(engine.coverage(), lit, 64);
  IslandFinder finder;
  CHECK(allocations_when_warm(3, [&] {
          for (Nanometers height{0}; height < Nanometers{20'250'000}; height += kThickLayer) {
            std::swap(bright, beneath);
            const Mask& mask = engine.mask_at(height);
            lit.extract(mask);
            bright.extract_bright(mask, lit, 64);
            (void)finder.find(bright, beneath, {4, 5 * 255});
          }
        }) == 0);
}

TEST_CASE("A warm engine allocates nothing for compensated masks") {
  // Two gyroids at one place overlap everywhere.
  const models::Facets facets =
      models::together(models::gyroid_sphere(10, 6, 24), models::gyroid_sphere(10, 5, 20));
  for (const double growth : {-60.0, 60.0}) {
    EngineSettings settings;
    settings.compensation = {Micrometers{growth}, Micrometers{100}, Nanometers{5'000'000}};
    settings.tone = {2.2, 10};
    settings.uniformity.emplace(kFineDisplay.width, kFineDisplay.height);
    CHECK(engine_allocations(facets, settings) == 0);
  }
}
