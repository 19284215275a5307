// Tests the light of rises, taken from the masks that they showed.
#include "daemon/report/printed_light.hpp"

#include <cmath>
#include <vector>

#include "core/continuous/rise_laws.hpp"
#include "core/cure/cured_part.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"

namespace {

using namespace std::chrono_literals;

constexpr double kIrradiance = 16;  // mW/cm2
constexpr double kMargin = 4;
constexpr CureSettings kWindowCure{.curve = {Micrometers{150}, MillijoulesPerCm2{8}},
                                   .dead_zone = Micrometers{30}};

double speed_mm_s() {
  return cure_speed({kWindowCure.curve, MilliwattsPerCm2{kIrradiance}, kWindowCure.dead_zone}, kMargin)
      .count();
}

LayerRecord lit_layer(std::int32_t layer, double lit_s) {
  LayerRecord record;
  record.layer = layer;
  record.bottom = testing::kBoxLayer * layer;
  record.thickness = testing::kBoxLayer;
  record.plate_height = record.bottom + record.thickness;
  record.mask_height = record.bottom + record.thickness / 2;
  record.exposure_least = record.exposure_most =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(lit_s));
  return record;
}

// A record of layers, and of masks 2 um apart at a constant speed.
struct RecordedRise {
  std::vector<LayerRecord> layers;
  std::vector<FrameRecord> frames;
};
RecordedRise recorded_rise(std::int32_t first_layers, std::int32_t all_layers) {
  RecordedRise rise;
  for (std::int32_t layer = 0; layer < all_layers; ++layer) {
    LayerRecord& record = rise.layers.emplace_back(
        lit_layer(layer, layer < first_layers ? 2 : in_mm(testing::kBoxLayer) / speed_mm_s()));
    record.rises = layer >= first_layers;
  }
  const Duration lit =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(0.002 / speed_mm_s()));
  for (Nanometers cut = testing::kBoxLayer * first_layers; cut < testing::kBoxLayer * all_layers;
       cut += Nanometers{2'000})
    rise.frames.push_back({.cut = cut,
                           .first = cut,
                           .last = cut + Nanometers{2'000},
                           .shown = TimePoint(lit * static_cast<std::int64_t>(rise.frames.size())),
                           .lit = lit,
                           .refreshes = 2,
                           .layer = static_cast<std::int32_t>(cut / testing::kBoxLayer),
                           .begins = rise.frames.empty()});
  return rise;
}

}  // namespace

TEST_CASE("Layers without a rise have the light of their records") {
  const std::vector<LayerRecord> layers{lit_layer(0, 4), lit_layer(1, 2)};
  const PrintedLight light = printed_light(layers, 5).value();
  REQUIRE(light.layers.size() == 2);
  CHECK(light.layers[1].dose.count() == Approx(10));
  CHECK(light.layers[1].peeled);
  CHECK(light.layers[1].thickness == testing::kBoxLayer);
  CHECK(light.mask_heights[1] == layers[1].mask_height);
  CHECK(layer_of(light, 1) == 1);
  CHECK_FALSE(light.rise);
  CHECK_FALSE(printed_light(std::span(layers).last(1), 5));
}

TEST_CASE("A rise's slices are replaced by steps of its masks, with all of their light") {
  const RecordedRise rise = recorded_rise(2, 20);
  const PrintedLight light = printed_light(rise.layers, kIrradiance, {rise.frames, kWindowCure}).value();
  CHECK(light.layers.size() == 2 + 225);  // 0.9 mm in steps of 4 um
  Nanometers beneath{};
  double dose = 0;
  for (std::size_t i = 0; i < light.layers.size(); ++i) {
    CAPTURE(i);
    const LayerDose& layer = light.layers[i];
    CHECK(layer.top - layer.thickness == beneath);
    CHECK(layer.thickness > Nanometers{});
    beneath = layer.top;
    CHECK(light.sources[i].is_step == (i >= 2));
    CHECK(layer.peeled == (i < 2 || i + 1 == light.layers.size()));
    if (i < 2) continue;
    dose += layer.dose.count();
    CHECK(std::abs((light.mask_heights[i] - layer.top).count()) <= 4'000);
  }
  double shown = 0;
  for (const FrameRecord& frame : rise.frames)
    shown += in_seconds(frame.lit) * kIrradiance;
  CHECK(dose == Approx(shown).epsilon(0.02));  // light is put up to 2 um higher: exp(2 / 150)
  REQUIRE(light.rise);
  CHECK(light.rise->masks == 450);
  CHECK(light.rise->step == Nanometers{4'000});
  CHECK(light.rise->margin == Approx(kMargin).epsilon(0.02));
  CHECK(light.rise->least_margin > kMargin * 0.98);
  CHECK(light.rise->print_through.count() == Approx(150 * std::log(kMargin)).margin(3));
}

TEST_CASE("Steps are as high as memory and time ask for") {
  const RecordedRise rise = recorded_rise(2, 20);
  const PrintedLight light = printed_light(rise.layers, kIrradiance, {rise.frames, kWindowCure, 30}).value();
  CHECK(light.layers.size() <= 2 + 30 + 1);
  CHECK(light.rise->step > Nanometers{29'000});
  CHECK(light.rise->margin == Approx(kMargin).epsilon(0.1));
  CHECK(light.layers.back().top == rise.frames.back().first + Nanometers{1'000});
}

TEST_CASE("A pause within a rise is a peel, and ends a step at the height at which the light comes back") {
  RecordedRise rise = recorded_rise(2, 20);
  FrameRecord& again = rise.frames[200];
  again.begins = true;
  again.first = again.last = again.cut = rise.frames[199].last - Nanometers{1'500};
  const PrintedLight light = printed_light(rise.layers, kIrradiance, {rise.frames, kWindowCure}).value();
  std::vector<std::size_t> peeled;
  for (std::size_t i = 2; i + 1 < light.layers.size(); ++i)
    if (light.layers[i].peeled) peeled.push_back(i);
  REQUIRE(peeled.size() == 1);
  CHECK(light.layers[peeled[0]].top == rise.frames[199].first + Nanometers{1'000});
  CHECK(light.layers[peeled[0] + 1].thickness > Nanometers{});
}

TEST_CASE("Slices count as layers where their masks are not known") {
  const RecordedRise rise = recorded_rise(2, 20);
  const PrintedLight light = printed_light(rise.layers, kIrradiance, {{}, kWindowCure}).value();
  CHECK(light.layers.size() == 20);
  CHECK_FALSE(light.rise);
}
