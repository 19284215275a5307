// Tests the light of rises, taken from the masks that they showed, and the part that it cures.
#include "daemon/report/printed_light.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include "core/continuous/rise_laws.hpp"
#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "daemon/print/continuous_print.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/models/models.hpp"

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

namespace {

constexpr std::int32_t kFirst = 4;

// A foot, a plate with a level underside, a waist whose walls face up and then down, and a lid.
models::Facets hourglass() {
  const std::vector<Point> profile{{0, 0},     {0.9, 0},   {0.9, 1}, {1.9, 1},
                                   {1.9, 1.4}, {1.2, 2.8}, {1.8, 4}, {0, 4}};
  return models::lathe(profile, 96);
}
constexpr double kHeightMm = 4;

ContourEngine hourglass_engine() {
  std::vector<PlateModel> models(1);
  models[0].model = std::make_shared<const HeightIndex>(hourglass());
  models[0].copies = {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})};
  return {std::move(models), EngineSettings{.display = testing::kSmallDisplay}};
}

// Prints on a simulated printer and keeps the records.
class RecordingPrint final : public PrintObserver {
 public:
  explicit RecordingPrint(PrintPlan plan) {
    process.start(std::move(plan));
    while (clock.run_next()) {
    }
  }
  RecordedRise recorded;
  PrintOutcome outcome = PrintOutcome::Failed;

 private:
  void light_due() override {}
  void state_changed(const PrintState&) override {}
  void layer_done(const LayerRecord& layer) override { recorded.layers.push_back(layer); }
  void frame_over(const FrameRecord& frame) override { recorded.frames.push_back(frame); }
  void interrupted(const std::string&) override {}
  void light_gone() override {}
  void print_ended(PrintOutcome how, const std::string&, PrintPlan) override { outcome = how; }

  VirtualClock clock;
  SimulatedPrinter printer{clock, testing::small_printer()};
  ContinuousPrint process{printer, clock, *this};
};

PrintPlan hourglass_plan() {
  const auto layers = static_cast<std::int32_t>(std::lround(kHeightMm / in_mm(testing::kBoxLayer)));
  PrintPlan plan = testing::box_plan(layers);
  plan.engine = std::make_unique<ContourEngine>(hourglass_engine());
  plan.exposure = [](std::int32_t, Nanometers) { return 2s; };
  const auto point = [](double height_mm, double speed) {
    return RisePoint{Nanometers{std::llround(height_mm * 1e6)}, MillimetersPerSecond{speed}, RiseLimit::Cure};
  };
  const double from = in_mm(testing::kBoxLayer) * kFirst;
  PlannedRise rise{.plan = {}, .first_layer = kFirst};
  rise.plan.points = {point(from, 0), point(from + 0.005, speed_mm_s()),
                      point(kHeightMm - 0.005, speed_mm_s()), point(kHeightMm, 0)};
  plan.rises.emplace();
  plan.rises->each.push_back(std::move(rise));
  return plan;
}

CureFigures cured_in_rise(const RecordedRise& recorded, const CureSettings& cure) {
  ContourEngine engine = hourglass_engine();
  const PrintedLight light = printed_light(recorded.layers, kIrradiance, {recorded.frames, cure}).value();
  return cure_part(engine, testing::kSmallDisplay,
                   {.layers = light.layers, .cure = cure, .mask_heights = light.mask_heights}, nullptr)
      .figures;
}

CureFigures cured_in_layers(Nanometers thickness, const CureSettings& cure) {
  ContourEngine engine = hourglass_engine();
  std::vector<LayerDose> layers;
  const LayerStack stack = layers_for(Millimeters{kHeightMm}, thickness);
  constexpr double kOvercure = 50;
  const MillijoulesPerCm2 dose =
      cure.curve.dose_for(Micrometers{in_mm(thickness) * 1000 + kOvercure + cure.dead_zone.count()});
  for (std::int32_t layer = 0; layer < stack.count; ++layer)
    layers.push_back({thickness * (layer + 1), thickness, dose});
  return cure_part(engine, testing::kSmallDisplay, {.layers = layers, .cure = cure}, nullptr).figures;
}

}  // namespace

TEST_CASE(
    "The part of a rise has better undersides and walls than 25 um layers of a resin that keeps its dose") {
  const RecordingPrint print(hourglass_plan());
  REQUIRE(print.outcome == PrintOutcome::Done);
  for (const double memory : {1.0, 0.9}) {
    CAPTURE(memory);
    CureSettings cure = kWindowCure;
    cure.peel_memory = memory;
    const CureFigures rise = cured_in_rise(print.recorded, cure);
    const CureFigures layers = cured_in_layers(Nanometers{25'000}, cure);
    CHECK(rise.undersides.missing == 0);
    CHECK(rise.undersides.median_um < layers.undersides.median_um);
    CHECK(rise.undersides.p95_um < layers.undersides.p95_um);
    CHECK(rise.walls.median_um < layers.walls.median_um);
    CHECK(rise.walls.p95_um < layers.walls.p95_um);
    CHECK(rise.too_much_mm3 < layers.too_much_mm3);
    // No peel takes dose: the print-through is the law's, and the dead zone's, at any memory.
    const double through_um = print_through(cure.curve, kMargin).count() + cure.dead_zone.count();
    CHECK(rise.undersides.median_um == Approx(through_um).margin(3));  // steps of 4 um, one way
    // Resin above the gel gap has gelled when the light ends; the plate is slower at its end.
    const double gap_um =
        gel_gap({cure.curve, MilliwattsPerCm2{kIrradiance}, cure.dead_zone}, kMargin).count();
    CHECK(rise.tops.median_um == Approx(-gap_um).margin(8));
  }
}

TEST_CASE("Layers of a resin that forgets its dose at each peel have better undersides than a rise") {
  const RecordingPrint print(hourglass_plan());
  CureSettings cure = kWindowCure;
  cure.peel_memory = 0;
  CHECK(cured_in_layers(Nanometers{25'000}, cure).undersides.median_um <
        cured_in_rise(print.recorded, cure).undersides.median_um);
}

TEST_CASE("The part from a rise's masks is more exact than the one from its slices") {
  const RecordingPrint print(hourglass_plan());
  const RecordedRise slices{print.recorded.layers, {}};
  const CureFigures from_masks = cured_in_rise(print.recorded, kWindowCure);
  const CureFigures from_slices = cured_in_rise(slices, kWindowCure);
  const double through_um = print_through(kWindowCure.curve, kMargin).count() + kWindowCure.dead_zone.count();
  CHECK(std::abs(from_masks.undersides.median_um - through_um) <
        std::abs(from_slices.undersides.median_um - through_um) / 2);
}
