// Models that stand above the plate, through the engine and the users of its masks.

#include "core/analysis/print_analysis.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/layers/print_layers.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

constexpr Nanometers kRaised{5'000'000};

// A model with slopes, a flat face inside and a part that begins in the air; its lowest point is not at 0.
std::shared_ptr<const HeightIndex> model() {
  models::Facets ball = models::sphere(4, 16);
  models::translate(ball, 0, 0, 2.3F);
  return shared_index(models::together(ball, models::box({5, 5, 1.5F}, {8, 8, 4})));
}

// A cracked model: a box without one of its facets.
std::shared_ptr<const HeightIndex> cracked_model() {
  models::Facets facets = models::box({-4, -4, 1}, {4, 4, 9});
  facets.erase(facets.begin() + 5);
  return shared_index(facets);
}

ContourEngine elevated_engine(const std::shared_ptr<const HeightIndex>& model, Elevation elevation,
                              EngineSettings settings = {}) {
  settings.display = kCoarseDisplay;
  return ContourEngine({plate_model(model, elevation)}, settings);
}

PrintFindings analyze(const std::shared_ptr<const HeightIndex>& model, Elevation elevation) {
  ContourEngine engine = elevated_engine(model, elevation);
  const LayerStack layers = layers_for(engine.models().front().top(), kCoarseLayer);
  return analyze_print(engine, kCoarseDisplay, PrintLayers(layers).all(), [](std::int32_t) { return 0s; })
      .value();
}

}  // namespace

TEST_CASE("A model above the plate has the masks of the model on the plate, higher by its elevation") {
  for (const auto& shape : {model(), cracked_model()}) {
    for (const AntiAliasing mode : {AntiAliasing::On, AntiAliasing::Off}) {
      for (const Micrometers growth : {Micrometers{0}, Micrometers{120}, Micrometers{-80}}) {
        EngineSettings settings;
        settings.anti_aliasing = mode;
        settings.compensation.growth = growth;
        ContourEngine low = elevated_engine(shape, {}, settings);
        ContourEngine high = elevated_engine(shape, Elevation(kRaised), settings);
        CHECK(high.mask_at(Nanometers{0}).lit_pixels() == 0);
        CHECK(high.mask_at(kRaised - Nanometers{1}).lit_pixels() == 0);
        for (Nanometers height{0}; height < Nanometers{9'000'000}; height += Nanometers{333'333}) {
          const Mask mask = low.mask_at(height);
          CHECK(high.mask_at(height + kRaised) == mask);
          CHECK(high.cracks() == low.cracks());
          CHECK(high.intersecting_facets() == low.intersecting_facets());
        }
      }
    }
  }
}

TEST_CASE("A model above the plate has the contours of the model on the plate, higher by its elevation") {
  ContourEngine low = elevated_engine(model(), {}), high = elevated_engine(model(), Elevation(kRaised));
  CHECK(high.contours_at(kRaised - Nanometers{1}).loops.empty());
  for (Nanometers height{0}; height < Nanometers{8'000'000}; height += Nanometers{333'333}) {
    const Contours contours = low.contours_at(height);
    CHECK(high.contours_at(height + kRaised).points == contours.points);
  }
}

TEST_CASE("The elephant foot is at the plate, and a model above the plate has none") {
  EngineSettings settings;
  settings.compensation = {Micrometers{0}, Micrometers{300}, Nanometers{6'000'000}};
  const auto box = shared_index(models::box({-4, -4, 0}, {4, 4, 8}));
  ContourEngine low = elevated_engine(box, {}, settings),
                high = elevated_engine(box, Elevation(kRaised), settings);
  // 0.3 mm less on each side at the plate; a sixth of that 5 mm above it, and none from 6 mm on.
  const auto area_mm2 = [](const Mask& mask) { return mask.lit_area() * 0.01; };
  const double tolerance = 32 * 0.1 / 255;  // mm2: half a grey value along the outline, twice
  CHECK(std::fabs(area_mm2(low.mask_at(Nanometers{0})) - 7.4 * 7.4) < tolerance);
  CHECK(std::fabs(area_mm2(high.mask_at(kRaised)) - 7.9 * 7.9) < tolerance);
  CHECK(std::fabs(area_mm2(high.mask_at(Nanometers{6'000'000})) - 64) < tolerance);
  // Cut at the model's own z.
  CHECK(Mask(high.mask_at_z(Millimeters{0})) == high.mask_at(kRaised));
  CHECK(Mask(high.mask_at_z(Millimeters{1})) == high.mask_at(Nanometers{6'000'000}));
}

TEST_CASE("Models of different elevations unite at the heights above the plate") {
  const auto box = shared_index(models::box({0, 0, 0}, {4, 4, 2}));
  const PixelMap left = PixelMap::true_scale(kCoarseDisplay, {8, 2}),
                 right = PixelMap::true_scale(kCoarseDisplay, {-4, 2});
  std::vector<PlateModel> models(2);
  models[0].model = models[1].model = box;
  models[1].elevation = Elevation(Nanometers{1'000'000});
  models[0].copies = {left};
  models[1].copies = {right};
  ContourEngine engine(std::move(models), {.display = kCoarseDisplay});
  const double one = 40 * 40;
  CHECK(engine.mask_at(Nanometers{500'000}).lit_area() == one);
  CHECK(engine.mask_at(Nanometers{1'500'000}).lit_area() == 2 * one);
  CHECK(engine.mask_at(Nanometers{2'500'000}).lit_area() == one);
  CHECK(engine.mask_at(Nanometers{3'000'000}).lit_pixels() == 0);
}

TEST_CASE("The analysis of a print finds the same in a model above the plate as in the model on it") {
  const PrintFindings low = analyze(model(), {}), high = analyze(model(), Elevation(kRaised));
  const std::int32_t below = 50;  // layers
  CHECK(high.layers() == low.layers() + below);
  CHECK(high.empty_layers.size() == low.empty_layers.size() + below);
  CHECK(std::vector(high.area_mm2.begin() + below, high.area_mm2.end()) == low.area_mm2);
  CHECK(high.volume_mm3 == low.volume_mm3);
  CHECK(high.largest_area_layer == low.largest_area_layer + below);
  // The model's underside is one more island, since nothing carries it.
  REQUIRE(low.islands.size() == 1);
  REQUIRE(high.islands.size() == 2);
  CHECK(high.islands[0].layer == below);
  CHECK(high.islands[1].layer == low.islands[0].layer + below);
  CHECK(high.islands[1].area_mm2 == low.islands[0].area_mm2);
}
