#include "core/analysis/print_analysis.hpp"
#include "core/layers/print_layers.hpp"

#include "core/model/mesh_report.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/near.hpp"
#include "tests/core/section_fixture.hpp"

using models::inverted;
using models::together;

namespace {

PrintFindings analyze(const models::Facets& facets, Nanometers thickness = kThickLayer,
                      const DisplayGeometry& display = kFineDisplay) {
  const LayerStack layers = layers_for(Millimeters{bounds_of(facets).size_z()}, thickness);
  ContourEngine engine = engine_for(facets, {display});
  return analyze_print(engine, display, PrintLayers(layers).all(), [](std::int32_t) { return 0s; }).value();
}

models::Facets ball(float x, float y, float z, double radius, int cells = 32) {
  models::Facets facets = models::sphere(radius, cells);
  models::translate(facets, x, y, z);
  return facets;
}

Facet facet(Vertex a, Vertex b, Vertex c) {
  return {{a, b, c}};
}

// Returns a pyramid of four sides on its tip, from (0, 0, 0) up to a square of side 2 * half at z = height.
models::Facets inverted_pyramid(float half, float height) {
  const Vertex tip{0, 0, 0}, a{-half, -half, height}, b{half, -half, height}, c{half, half, height},
      d{-half, half, height};
  return {facet(tip, b, a), facet(tip, c, b), facet(tip, d, c),
          facet(tip, a, d), facet(a, b, c),   facet(a, c, d)};
}

}  // namespace

TEST_CASE("A box has its volume and its area and no other findings") {
  const PrintFindings found = analyze(models::box({-5, -4, 0}, {5, 4, 10}));
  CHECK(found.layers() == 20);
  CHECK(near(found.volume_mm3, 800, 800 * 1e-12));
  CHECK(near(found.resin_ml(), 0.8, 1e-12));
  for (const double area : found.area_mm2)
    CHECK(near(area, 80));
  CHECK(near(found.largest_area_mm2, 80));
  CHECK(found.largest_area_layer == 0);
  CHECK(found.empty_layers.empty());
  CHECK(found.island_count == 0);
  CHECK(found.cracked_layers.empty());
}

TEST_CASE("An inverted pyramid is largest at its top and stands on its tip") {
  const PrintFindings found = analyze(inverted_pyramid(8, 10));
  CHECK(found.layers() == 20);
  CHECK(found.island_count == 0);
  CHECK(found.largest_area_layer == 19);
  // The last layer is cut 0.25 mm below the top. Each edge pixel of a side of a hundred pixels or more is
  // rounded to 1/255.
  const double side = 16 * 9.75 / 10;
  CHECK(near(found.largest_area_mm2, side * side, 0.01));
}

TEST_CASE("The middle of a bridge is no island, but a part that hangs from it is") {
  const models::Facets bridge =
      together(together(models::box({-8, -2, 0}, {-6, 2, 8}), models::box({6, -2, 0}, {8, 2, 8})),
               models::box({-8, -2, 8}, {8, 2, 10}));
  CHECK(analyze(bridge).island_count == 0);
  const PrintFindings hung = analyze(together(bridge, models::box({-1, -0.5, 5}, {2, 0.5, 8})));
  REQUIRE(hung.islands.size() == 1);
  CHECK(hung.island_count == 1);
  CHECK(hung.islands[0].layer == 10);
  CHECK(near(hung.islands[0].area_mm2, 3));
  CHECK(near(hung.islands[0].plate_mm.x, 0.5));
  CHECK(near(hung.islands[0].plate_mm.y, 0));
  CHECK(near(hung.islands[0].pixel.x, 250));
  CHECK(near(hung.islands[0].pixel.y, 220));
}

TEST_CASE("Mirrors do not change an island's place on the plate") {
  const models::Facets model =
      together(models::box({-8, -8, 0}, {-6, -6, 8}), models::box({4, 5, 4}, {6, 7, 8}));
  for (const bool mirror_x : {false, true}) {
    for (const bool mirror_y : {false, true}) {
      DisplayGeometry display = kFineDisplay;
      display.mirror_x = mirror_x;
      display.mirror_y = mirror_y;
      const PrintFindings found = analyze(model, kThickLayer, display);
      REQUIRE(found.islands.size() == 1);
      CHECK(near(found.islands[0].plate_mm.x, 5));
      CHECK(near(found.islands[0].plate_mm.y, 6));
      CHECK((found.islands[0].pixel.x < 240) == mirror_x);
    }
  }
}

TEST_CASE("Two towers that both stand on the plate are no islands") {
  CHECK(analyze(together(models::box({-8, 0, 0}, {-5, 3, 9}), models::box({5, 0, 0}, {8, 3, 5})))
            .island_count == 0);
}

TEST_CASE("A floating ball is one island where it begins") {
  const PrintFindings found = analyze(together(models::box({-8, -8, 0}, {8, 8, 1}), ball(3, -2, 6, 3)));
  REQUIRE(found.islands.size() == 1);
  // The ball begins at 3 mm; 4 layers of that, above the slab's two, are dark.
  CHECK(found.islands[0].layer == 6);
  // The lowest point of the ball (a marching-cubes mesh) is a vertex of a grid of 0.2 mm.
  CHECK(near(found.islands[0].plate_mm.x, 3, 0.2));
  CHECK(near(found.islands[0].plate_mm.y, -2, 0.2));
  CHECK(found.empty_layers == std::vector<std::int32_t>{2, 3, 4, 5});
}

TEST_CASE("Dark layers at the end of a print are empty layers") {
  // The engine knows only the model; the print goes on above it.
  ContourEngine engine = engine_for(models::box({0, 0, 0}, {2, 2, 2}));
  const auto found =
      analyze_print(engine, kFineDisplay, std::vector(10, kThickLayer), [](std::int32_t) { return 1s; });
  REQUIRE(found);
  CHECK(found->layers() == 10);
  CHECK(found->empty_layers == std::vector<std::int32_t>{4, 5, 6, 7, 8, 9});
  CHECK(found->layer_time == 10s);
}

TEST_CASE("A last layer in a tip that is too small for a pixel is not an empty layer") {
  const PrintFindings found =
      analyze(together(models::box({0, 0, 0}, {2, 2, 2}), models::box({0, 0, 2}, {1e-5F, 2, 2.5F})));
  CHECK(found.layers() == 5);
  CHECK(found.area_mm2.back() == 0);
  CHECK(found.empty_layers.empty());
}

TEST_CASE("Every layer of a print without light is empty") {
  // Thinner than a pixel can show.
  CHECK(analyze(models::box({0, 0, 0}, {2, 1e-5F, 0.4F})).empty_layers == std::vector<std::int32_t>{0});
  CHECK(analyze(models::box({0, 0, 0}, {2, 1e-5F, 1})).empty_layers == std::vector<std::int32_t>{0, 1});
}

TEST_CASE("A dark first layer makes the part above it an island") {
  PrintAnalysis analysis(kFineDisplay);
  Mask mask(kFineDisplay.width, kFineDisplay.height);
  analysis.add_layer(mask, {kThickLayer, 0s, {}});
  mask.row(10)[10] = 255;
  analysis.add_layer(mask, {kThickLayer, 0s, {}});
  analysis.add_layer(mask, {kThickLayer, 0s, {}});
  CHECK(analysis.findings().empty_layers == std::vector<std::int32_t>{0});
  CHECK(analysis.findings().island_count == 1);
}

TEST_CASE("A hollow ball has the resin of its wall, and one island if something lies in it") {
  const models::Facets shell = together(ball(0, 0, 0, 8, 48), inverted(ball(0, 0, 0, 6, 48)));
  const PrintFindings found = analyze(shell, Nanometers{100'000});
  CHECK(found.island_count == 0);
  // Layers of 0.1 mm cut at their middles: the error of the midpoint rule on pi (r^2 - z^2) is pi h^3 / 12 a
  // layer, 0.04 mm3 in all; the grey values' rounding adds 1/510 of the edge pixels' area.
  const double mesh_volume = inspect_mesh(shell).volume_mm3;
  CHECK(near(found.volume_mm3, mesh_volume, 0.5));
  CHECK(near(found.volume_mm3, 4 * std::numbers::pi / 3 * (512 - 216), 15));  // facets cut corners
  const PrintFindings filled = analyze(together(shell, ball(0, 0, 0, 2)), Nanometers{100'000});
  REQUIRE(filled.islands.size() == 1);
  CHECK(filled.islands[0].layer == 60);
}

namespace {

// Returns a box of 20 x 20 x 10 mm from z = 0 with a hollow of 10 x 10 mm from one height to another.
models::Facets hollowed(float from, float to) {
  return together(models::box({-10, -10, 0}, {10, 10, 10}),
                  inverted(models::box({-5, -5, from}, {5, 5, to})));
}

// Returns a duct of 2 x 2 mm from the hollow's wall out to x = 10, as an inverted box.
models::Facets duct(float from, float to) {
  return inverted(models::box({5, -1, from}, {10, 1, to}));
}

}  // namespace

TEST_CASE("A cup that opens towards the film sucks, and one that opens towards the plate is on the plate") {
  // Layers of 0.5 mm.
  const PrintFindings upright = analyze(hollowed(2, 10));
  CHECK(upright.resin_trap_count == 0);
  REQUIRE(upright.suction_cups.size() == 1);
  const PrintVoid& cup = upright.suction_cups[0];
  CHECK(cup.first_layer == 4);
  CHECK(cup.last_layer == 19);
  CHECK(cup.widest_layer == 4);
  CHECK(near(cup.area_mm2, 100));
  CHECK(near(cup.volume_mm3, 800, 1e-6));
  CHECK(near(cup.plate_mm.x, 0));
  CHECK(!cup.on_plate);
  const PrintFindings down = analyze(hollowed(0, 8));
  CHECK(down.resin_trap_count == 0);
  REQUIRE(down.suction_cups.size() == 1);
  CHECK(down.suction_cups[0].on_plate);
  CHECK(down.suction_cups[0].last_layer == 15);
}

TEST_CASE("A tube on the plate is a cup up to its end, a tube above a gap is none") {
  const PrintFindings tube = analyze(hollowed(0, 10));
  REQUIRE(tube.suction_cups.size() == 1);
  CHECK(tube.suction_cups[0].on_plate);
  CHECK(tube.suction_cups[0].first_layer == 0);
  CHECK(tube.suction_cups[0].last_layer == 19);
  CHECK(tube.resin_trap_count == 0);
  models::Facets above = hollowed(0, 10);
  models::translate(above, 0, 0, 2);
  const PrintFindings lifted = analyze(together(above, models::box({-10, -10, 0}, {-9, -9, 2})));
  // The gap is reported by warnings of its own.
  CHECK(lifted.suction_cup_count == 0);
}

TEST_CASE("A closed hollow sucks and then keeps resin, and a duct ends the suction where it opens") {
  const PrintFindings closed = analyze(hollowed(2, 8));
  REQUIRE(closed.resin_traps.size() == 1);
  CHECK(closed.resin_trap_count == 1);
  CHECK(near(closed.resin_traps[0].volume_mm3, 600, 1e-6));
  CHECK(closed.resin_traps[0].first_layer == 4);
  CHECK(closed.resin_traps[0].last_layer == 15);
  CHECK(closed.suction_cup_count == 1);
  // With a duct at its lower end the hollow never sucks.
  const PrintFindings low = analyze(together(hollowed(2, 8), duct(2, 3)));
  CHECK(low.resin_trap_count == 0);
  CHECK(low.suction_cup_count == 0);
  // With a duct at its upper end it sucks up to the duct.
  const PrintFindings high = analyze(together(hollowed(2, 8), duct(7, 8)));
  CHECK(high.resin_trap_count == 0);
  REQUIRE(high.suction_cups.size() == 1);
  CHECK(high.suction_cups[0].last_layer == 13);
}

TEST_CASE("A hollow ball traps the resin inside it") {
  const models::Facets shell = together(ball(0, 0, 0, 8, 48), inverted(ball(0, 0, 0, 6, 48)));
  const PrintFindings found = analyze(shell, Nanometers{100'000});
  REQUIRE(found.resin_traps.size() == 1);
  // On average a quarter of each pixel at the wall is left out, and a layer has 2 pi r / 0.05 mm of them: 1
  // %.
  const double volume_mm3 = 4 * std::numbers::pi / 3 * 216;
  CHECK(near(found.resin_traps[0].volume_mm3, volume_mm3, 0.02 * volume_mm3));
  CHECK(near(found.resin_traps[0].plate_mm.x, 0, 0.01));
  // The widest layer is the middle one, where 0.1 mm of height changes the area by only 0.0008 of it.
  CHECK(near(found.suction_cups.at(0).widest_layer, 80, 5));
}

TEST_CASE("A bottle that stands on its floor sucks up to the end of its neck and keeps no resin") {
  // The floor is printed first, then the belly, then the neck of 4 x 4 mm.
  const models::Facets bottle =
      together(together(models::box({-8, -8, 0}, {8, 8, 8}), models::box({-3, -3, 8}, {3, 3, 12})),
               together(inverted(models::box({-7, -7, 1}, {7, 7, 7})),
                        inverted(models::box({-2, -2, 7}, {2, 2, 12}))));
  const PrintFindings found = analyze(bottle);
  CHECK(found.resin_trap_count == 0);
  REQUIRE(found.suction_cups.size() == 1);
  CHECK(near(found.suction_cups[0].area_mm2, 14 * 14));
  CHECK(near(found.suction_cups[0].volume_mm3, 14 * 14 * 6 + 4 * 4 * 5, 1e-6));
  CHECK(found.suction_cups[0].last_layer == 23);
}

TEST_CASE("Too small hollows are not reported, and the largest of many are kept") {
  // Each hollow is 1.5 x 1.5 mm wide and 0.4 mm high.
  PrintAnalysis analysis(kFineDisplay, {}, {.cup_area_mm2 = 0, .cup_volume_mm3 = 0, .trap_volume_mm3 = 0});
  PrintAnalysis usual(kFineDisplay);
  Mask full(kFineDisplay.width, kFineDisplay.height), holes(kFineDisplay.width, kFineDisplay.height);
  for (std::int32_t y = 1; y < 439; ++y) {
    std::fill(full.row(y).begin() + 1, full.row(y).end() - 1, std::uint8_t{255});
    std::copy(full.row(y).begin(), full.row(y).end(), holes.row(y).begin());
  }
  // 60 x 40 hollows, every tenth of them twice as large.
  for (std::int32_t i = 0; i < 2400; ++i) {
    const std::int32_t x = 10 + i % 60 * 7, y = 10 + i / 60 * 10;
    for (std::int32_t dx = 0; dx < (i % 10 == 0 ? 4 : 2); ++dx)
      holes.row(y)[static_cast<std::size_t>(x + dx)] = 0;
  }
  for (PrintAnalysis* each : {&analysis, &usual}) {
    for (const Mask* mask : {&full, &holes, &full})
      each->add_layer(*mask, {kThickLayer, 0s, {}});
    each->end();
  }
  const PrintFindings& found = analysis.findings();
  CHECK(found.resin_trap_count == 2400);
  CHECK(found.suction_cup_count == 2400);
  REQUIRE(found.resin_traps.size() == PrintFindings::kMaxVoids);
  CHECK(std::ranges::count_if(found.suction_cups, [](const PrintVoid& v) { return v.area_mm2 > 0.006; }) ==
        240);
  CHECK(usual.findings().resin_trap_count == 0);
  CHECK(usual.findings().suction_cup_count == 0);
}

TEST_CASE("A hollow continues through a layer whose mask was abandoned") {
  PrintAnalysis analysis(kFineDisplay);
  Mask full(kFineDisplay.width, kFineDisplay.height);
  for (std::int32_t y = 100; y < 300; ++y)
    std::fill(full.row(y).begin() + 100, full.row(y).begin() + 300, std::uint8_t{255});
  Mask ring = full;
  for (std::int32_t y = 120; y < 220; ++y)
    std::fill(ring.row(y).begin() + 120, ring.row(y).begin() + 220, std::uint8_t{0});
  analysis.add_layer(full, {kThickLayer, 0s, {}});
  analysis.add_layer(ring, {kThickLayer, 0s, {}});
  analysis.add_abandoned_layer({kThickLayer, 0s, {}});
  analysis.add_layer(ring, {kThickLayer, 0s, {}});
  analysis.add_layer(full, {kThickLayer, 0s, {}});
  analysis.end();
  REQUIRE(analysis.findings().resin_traps.size() == 1);
  CHECK(analysis.findings().resin_traps[0].first_layer == 1);
  CHECK(analysis.findings().resin_traps[0].last_layer == 3);
  // 5 x 5 mm, two layers high.
  CHECK(near(analysis.findings().resin_traps[0].volume_mm3, 25, 1e-9));
}

TEST_CASE("A gyroid keeps no resin") {
  CHECK(analyze(models::gyroid_sphere(9, 6, 48), Nanometers{100'000}).resin_trap_count == 0);
}

TEST_CASE("A gyroid's resin is its mesh's volume") {
  models::Facets facets = models::gyroid_sphere(9, 6, 48);
  const PrintFindings found = analyze(facets, Nanometers{50'000});
  const double mesh_volume = inspect_mesh(facets).volume_mm3;
  // Grey values are rounded to 1/255 without bias, and layers are thin compared with the gyroid's walls of a
  // millimetre.
  CHECK(near(found.volume_mm3, mesh_volume, 1e-3 * mesh_volume));
  CHECK(found.layers() == static_cast<std::int32_t>(found.area_mm2.size()));
}

TEST_CASE("Pixels below the threshold count neither as area nor as island nor as support") {
  // A pin that covers a quarter of a pixel holds a plate 1 mm above another.
  const models::Facets facets =
      together(together(models::box({-2, -2, 0}, {2, 2, 1}), models::box({0, 0, 1}, {0.025F, 0.025F, 2})),
               models::box({-2, -2, 2}, {2, 2, 3}));
  const CarryingSupport anything{.least_grey = 1, .contact_area_mm2 = 0};
  const auto found_with = [&](const ToneCurve& tone, const CarryingSupport& support) {
    ContourEngine engine(HeightIndex(facets),
                         EngineSettings{kFineDisplay, AntiAliasing::On, Compensation{}, tone, std::nullopt},
                         {PixelMap::true_scale(kFineDisplay, {0, 0})});
    return analyze_print(engine, kFineDisplay, std::vector(6, kThickLayer), [](std::int32_t) { return 0s; },
                         {}, {support, {}})
        .value();
  };
  const PrintFindings all = found_with({}, anything), bright = found_with({2.2, 64}, anything),
                      cut = found_with({2.2, 65}, anything);
  CHECK(all.empty_layers.empty());
  CHECK(all.island_count == 0);
  // Nor does the pin carry the plate, unless any contact is enough.
  CHECK(found_with({}, {}).island_count == 1);
  // A quarter of a pixel has grey 64 of 255.
  CHECK(bright.area_mm2 == all.area_mm2);
  CHECK(cut.area_mm2[2] == 0);
  CHECK(cut.area_mm2[4] == all.area_mm2[4]);
  CHECK(cut.empty_layers == std::vector<std::int32_t>{2, 3});
  CHECK(cut.island_count == 1);
}

TEST_CASE("Cracks are summed and listed by layer") {
  models::Facets box = models::box({0, 0, 0}, {2, 2, 2});
  box.pop_back();
  const PrintFindings found = analyze(together(box, models::box({4, 4, 0}, {6, 6, 4})));
  CHECK(found.layers() == 8);
  CHECK(found.cracks.open_chains == found.cracked_layers.size());
  REQUIRE(found.cracked_layers.size() == 4);
  CHECK(found.cracked_layers[3].layer == 3);
  CHECK(found.cracks.widest_gap > Millimeters{1});
}

TEST_CASE("The time is the sum over all layers") {
  ContourEngine engine = engine_for(models::box({0, 0, 0}, {2, 2, 2}));
  const auto found = analyze_print(engine, kFineDisplay, std::vector(4, kThickLayer),
                                   [](std::int32_t layer) { return 2s + 100ms * layer; });
  REQUIRE(found);
  CHECK(found->layer_time == 8600ms);
}

TEST_CASE("Islands beyond the maximum that is kept are still counted") {
  const DisplayGeometry display{Pixels{200}, Pixels{200}};
  PrintAnalysis analysis(display);
  Mask mask(display.width, display.height);
  analysis.add_layer(mask, {kThickLayer, 0s, {}});
  for (std::int32_t y = 0; y < 200; y += 2) {
    for (std::size_t x = 0; x < 200; x += 2)
      mask.row(y)[x] = 255;
  }
  analysis.add_layer(mask, {kThickLayer, 0s, {}});
  analysis.add_layer(mask, {kThickLayer, 0s, {}});  // so that the islands are no specks of one layer
  CHECK(analysis.findings().island_count == 10'000);
  CHECK(analysis.findings().islands.front().layer == 1);
  CHECK(analysis.findings().islands.size() == PrintFindings::kMaxIslands);
}

TEST_CASE("A dot of exactly 0.0125 mm2 is a speck, however the pitch is rounded") {
  for (const auto& [pitch_um, pixels] : {std::pair(50.0, 5U), std::pair(25.0, 20U), std::pair(100.0, 1U)}) {
    CAPTURE(pitch_um);
    const DisplayGeometry display{Pixels{40}, Pixels{8}, Micrometers{pitch_um}};
    for (const std::size_t more : {0U, 1U}) {
      PrintAnalysis analysis(display);
      Mask mask(display.width, display.height);
      mask.row(1)[1] = 255;
      analysis.add_layer(mask, {kThickLayer, 0s, {}});
      std::ranges::fill_n(mask.row(5).begin() + 4, static_cast<std::ptrdiff_t>(pixels + more), 255);
      analysis.add_layer(mask, {kThickLayer, 0s, {}});
      CHECK(analysis.findings().island_count == more);
    }
  }
}

TEST_CASE("A stopped analysis returns nothing") {
  ContourEngine engine = engine_for(models::box({0, 0, 0}, {2, 2, 2}));
  std::stop_source source;
  std::int32_t asked = 0;
  const auto found = analyze_print(
      engine, kFineDisplay, std::vector(4, kThickLayer),
      [&](std::int32_t) {
        if (++asked == 2) source.request_stop();
        return 1s;
      },
      source.get_token());
  CHECK(!found);
  CHECK(asked == 2);
}

TEST_CASE("Nothing above an abandoned first layer is an island, but islands further up are reported") {
  const DisplayGeometry display{Pixels{8}, Pixels{6}, Micrometers{50.0}};
  const auto lit_at = [&](std::int32_t row) {
    Mask mask(display.width, display.height);
    for (std::uint8_t& grey : mask.row(row))
      grey = 255;
    return mask;
  };
  PrintAnalysis analysis(display);
  analysis.add_abandoned_layer({});
  analysis.add_layer(lit_at(1), {});
  CHECK(analysis.findings().island_count == 0);
  analysis.add_layer(lit_at(4), {});
  CHECK(analysis.findings().island_count == 1);
}
