// Checks the promise "Allocates nothing once it has seen its largest section".
#include <memory>
#include <utility>
#include <vector>

#include "core/analysis/island_finder.hpp"
#include "core/analysis/void_finder.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/mask_runs.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd;

namespace {

constexpr Nanometers kLayer{500'000};

// Returns the allocations of a second pass over all layers.
long allocations_when_warm(models::Facets facets, EngineSettings settings = {}) {
  settings.display = {Pixels{480}, Pixels{480}};
  const auto model = std::make_shared<const HeightIndex>(std::move(facets));
  const PixelMap map = PixelMap::true_scale(settings.display, {0, 0});
  ContourEngine engine(std::vector<PlateModel>{{{model}, {map}}, {{model}, {map, map}}}, settings);
  long during_second = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const long before = testing::allocations();
    for (Nanometers height{0}; height < Nanometers{20'000'000}; height += kLayer) {
      (void)engine.mask_at(height);
      (void)engine.count_loops();
      (void)engine.contours_at(height);
    }
    during_second = testing::allocations() - before;
  }
  return during_second;
}

}  // namespace

TEST_CASE("Allocations are counted") {
  const long before = testing::allocations();
  const std::vector<int> memory(1000);
  CHECK(testing::allocations() > before);
}

TEST_CASE("A warm engine allocates nothing for a sound model") {
  CHECK(allocations_when_warm(models::gyroid_sphere(10, 6, 24)) == 0);
}

TEST_CASE("A warm engine allocates nothing for a cracked model") {
  models::Facets facets = models::gyroid_sphere(10, 6, 24);
  for (std::size_t i = 0; i < facets.size(); i += 100)
    facets[i] = facets.back();
  CHECK(allocations_when_warm(facets) == 0);
}

TEST_CASE("A warm engine allocates nothing for a duplicated model") {
  models::Facets facets = models::gyroid_sphere(10, 6, 24);
  const models::Facets copy = facets;
  facets.insert(facets.end(), copy.begin(), copy.end());
  CHECK(allocations_when_warm(facets) == 0);
}

TEST_CASE("Finding voids allocates nothing when warm") {
  const DisplayGeometry display{Pixels{480}, Pixels{480}};
  ContourEngine engine(HeightIndex(models::gyroid_sphere(10, 6, 24)),
                       EngineSettings{display, AntiAliasing::On}, {PixelMap::true_scale(display, {0, 0})});
  MaskRuns solid;
  VoidFinder finder;
  long during_last = 0;
  for (int pass = 0; pass < 3; ++pass) {
    const long before = testing::allocations();
    for (std::int32_t layer = 0; kLayer * layer < Nanometers{20'250'000}; ++layer) {
      solid.extract(engine.mask_at(kLayer * layer));
      (void)finder.add_layer(solid, {layer, kLayer});
    }
    (void)finder.end();
    during_last = testing::allocations() - before;
  }
  CHECK(during_last == 0);
}

TEST_CASE("Finding islands allocates nothing when warm") {
  const DisplayGeometry display{Pixels{480}, Pixels{480}};
  ContourEngine engine(HeightIndex(models::gyroid_sphere(10, 6, 24)),
                       EngineSettings{display, AntiAliasing::On}, {PixelMap::true_scale(display, {0, 0})});
  // Runs alternate between two layers, as in an analysis: both must have seen the largest.
  MaskRuns lit, bright, beneath;
  lit.extract(engine.coverage());
  bright.extract_bright(engine.coverage(), lit, 64);
  IslandFinder finder;
  long during_last = 0;
  for (int pass = 0; pass < 3; ++pass) {
    const long before = testing::allocations();
    for (Nanometers height{0}; height < Nanometers{20'250'000}; height += kLayer) {
      std::swap(bright, beneath);
      const Mask& mask = engine.mask_at(height);
      lit.extract(mask);
      bright.extract_bright(mask, lit, 64);
      (void)finder.find(bright, beneath, {4, 5 * 255});
    }
    during_last = testing::allocations() - before;
  }
  CHECK(during_last == 0);
}

TEST_CASE("A warm engine allocates nothing for compensated masks") {
  // Two gyroids at one place overlap everywhere.
  models::Facets facets = models::gyroid_sphere(10, 6, 24);
  models::Facets other = models::gyroid_sphere(10, 5, 20);
  facets.insert(facets.end(), other.begin(), other.end());
  for (const double growth : {-60.0, 60.0}) {
    EngineSettings settings;
    settings.compensation = {Micrometers{growth}, Micrometers{100}, Nanometers{5'000'000}};
    settings.tone = {2.2, 10};
    settings.uniformity.emplace(Pixels{480}, Pixels{480});
    CHECK(allocations_when_warm(facets, settings) == 0);
  }
}
