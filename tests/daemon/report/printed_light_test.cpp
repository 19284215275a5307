// Tests the light of rises, taken from the masks that they showed, and the part that it cures.
#include "daemon/report/printed_light.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/continuous/rise_laws.hpp"
#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "daemon/print/continuous_print.hpp"
#include "daemon/print/rise_forecast.hpp"
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

ContourEngine engine_of(models::Facets facets) {
  std::vector<PlateModel> models(1);
  models[0].model = std::make_shared<const HeightIndex>(std::move(facets));
  models[0].copies = {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})};
  return {std::move(models), EngineSettings{.display = testing::kSmallDisplay}};
}

ContourEngine hourglass_engine() {
  return engine_of(hourglass());
}

// Prints on a simulated printer and keeps the records.
class RecordingPrint final : public PrintObserver {
 public:
  // Calls `at_height` with the plate's height while it rises.
  using AtHeight = std::function<void(ContinuousPrint&, Nanometers)>;
  explicit RecordingPrint(
      PrintPlan plan, SimulatedPrinterConfig config = testing::small_printer(),
      const AtHeight& at_height = [](ContinuousPrint&, Nanometers) {})
      : printer(clock, config) {
    process.start(std::move(plan));
    while (clock.run_next()) {
      if (process.continuous_state() == ContinuousState::Rising)
        at_height(process, printer.z_axis().height().value());
      if (process.continuous_state() == ContinuousState::Paused && pauses++ == 0) process.resume();
    }
  }
  RecordedRise recorded;
  PrintOutcome outcome = PrintOutcome::Failed;
  int pauses = 0;  // only the first one is ended

 private:
  void light_due() override {}
  void state_changed(const PrintState&) override {}
  void layer_done(const LayerRecord& layer) override { recorded.layers.push_back(layer); }
  void frame_over(const FrameRecord& frame) override { recorded.frames.push_back(frame); }
  void interrupted(const std::string&) override {}
  void light_gone() override {}
  void print_ended(PrintOutcome how, const std::string&, PrintPlan) override { outcome = how; }

  VirtualClock clock;
  SimulatedPrinter printer;
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
  const LitResin lit{kWindowCure.curve, MilliwattsPerCm2{kIrradiance}, kWindowCure.dead_zone};
  rise.plan.overrun = Nanometers{std::llround(gel_gap(lit, kMargin).count() * 1000)};
  plan.rises.emplace();
  plan.rises->bounds.lit = lit;
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

// Returns how far undersides of thick parts end too low in the rise of the hourglass.
double underside_um(const CureSettings& cure) {
  const LitResin lit{cure.curve, MilliwattsPerCm2{kIrradiance}, cure.dead_zone};
  return print_through(cure.curve, kMargin).count() + cure.dead_zone.count() - gel_gap(lit, kMargin).count();
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
    if (memory == 1) CHECK(rise.walls.median_um < layers.walls.median_um);
    CHECK(rise.walls.p95_um < layers.walls.p95_um);
    CHECK(rise.too_much_mm3 < layers.too_much_mm3);
    // No peel takes dose: the print-through is the law's, less the way by which the masks are behind, at any
    // memory.
    CHECK(rise.undersides.median_um == Approx(underside_um(cure)).margin(3));  // steps of 4 um, one way
    CHECK(rise.tops.median_um == Approx(0).margin(4));
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
  const double low_um = underside_um(kWindowCure);
  CHECK(std::abs(from_masks.undersides.median_um - low_um) <
        std::abs(from_slices.undersides.median_um - low_um) / 2);
}

namespace {

constexpr double kTopMm = 2;

// Models whose walls lie between pixels, which are all lit or not at all.
models::Facets needle() {
  return models::box({-0.2F, -0.2F, 0}, {0.3F, 0.3F, 2});
}
models::Facets block() {
  return models::box({-2, -1.5F, 0}, {2, 1.5F, 2});
}
// Three steps, of which only the uppermost ends between two layers.
models::Facets pyramid() {
  return models::together({models::box({-2, -2, 0}, {2, 2, 0.777F}),
                           models::box({-1.4F, -1.4F, 0}, {1.4F, 1.4F, 1.473F}),
                           models::box({-0.7F, -0.7F, 0}, {0.7F, 0.7F, 2})});
}

// A resin in the light, its margin, and the distances of the sections up to these heights, in mm.
struct RiseCase {
  LitResin lit{};
  double margin = 4;
  std::vector<std::pair<double, double>> distances{{kTopMm, 2.0}};
};

RiseBounds bounds_of(const RiseCase& from) {
  return {.lit = from.lit,
          .margin = from.margin,
          .refill = {.viscosity_pa_s = 0.2, .pressure_kpa = 50},
          .fastest = MillimetersPerSecond{0.12},  // 2 um a refresh
          .slowest = MillimetersPerSecond{0.0005},
          .acceleration = MillimetersPerSecondSquared{25},
          .window = std::chrono::hours{10}};
}

CureSettings cure_of(const RiseCase& from, double memory = 1) {
  return {.curve = from.lit.curve, .peel_memory = memory, .dead_zone = from.lit.dead_zone};
}

// Plans the rises of a model up to a height, with layers of kBoxLayer.
PrintPlan plan_of(models::Facets facets, const RiseCase& from, RiseBounds bounds) {
  const double irradiance = from.lit.irradiance.count();
  PrintPlan plan = testing::box_plan(static_cast<int>(std::lround(kTopMm / in_mm(testing::kBoxLayer))));
  plan.engine = std::make_unique<ContourEngine>(engine_of(std::move(facets)));
  const Micrometers depth{in_mm(testing::kBoxLayer) * 1000 + 50 + from.lit.dead_zone.count()};
  const std::chrono::duration<double> exposure(from.lit.curve.dose_for(depth).count() / irradiance);
  plan.exposure = [exposure](std::int32_t, Nanometers) {
    return std::chrono::duration_cast<Duration>(exposure);
  };
  std::vector<RiseSlab> slabs;
  const Nanometers thickness =
      slab_thickness(Nanometers{2'000'000}, testing::kBoxLayer, gel_gap(from.lit, from.margin));
  for (Nanometers top = thickness; in_mm(top) < kTopMm + 1e-9; top += thickness) {
    const auto at = std::ranges::find_if(from.distances,
                                         [&](const auto& each) { return in_mm(top) <= each.first + 1e-9; });
    slabs.push_back({top, Millimeters{at->second}});
  }
  slabs.back().top = Nanometers{2'000'000};
  const std::vector<Duration> times(plan.expected_layers.size());
  PlannedRises& rises = plan.rises.emplace();
  rises.bounds = bounds;
  rises.slowest = bounds.slowest;
  rises.slabs = std::make_shared<const std::vector<RiseSlab>>(slabs);
  rises.each = rises_between(plan_rises(slabs, Nanometers{200'000}, bounds), plan.expected_layers, times,
                             {.window = std::chrono::hours{10}, .recovery = std::chrono::seconds{1}});
  return plan;
}

CureFigures cured_in(const models::Facets& facets, const RecordedRise& recorded, const RiseCase& from,
                     double memory = 1) {
  ContourEngine engine = engine_of(facets);
  const CureSettings cure = cure_of(from, memory);
  const PrintedLight light =
      printed_light(recorded.layers, from.lit.irradiance.count(), {recorded.frames, cure}).value();
  return cure_part(engine, testing::kSmallDisplay,
                   {.layers = light.layers, .cure = cure, .mask_heights = light.mask_heights}, nullptr)
      .figures;
}

LitResin lit(double depth_um, double critical_mj, double irradiance, double dead_zone_um) {
  return {{Micrometers{depth_um}, MillijoulesPerCm2{critical_mj}},
          MilliwattsPerCm2{irradiance},
          Micrometers{dead_zone_um}};
}

// Masks come every 2 um, and the recorded light is joined to steps of 4 um.
constexpr double kTopTolerance_um = 6;

}  // namespace

TEST_CASE("Level tops of a rise end at their height, in each resin and at each margin") {
  for (const RiseCase& each :
       std::initializer_list<RiseCase>{{lit(150, 8, 4, 30), 4},
                                       {lit(150, 8, 16, 30), 2},
                                       {lit(150, 8, 16, 5), 1.5, {{kTopMm, 0.2}}},
                                       {lit(80, 12, 20, 60), 6},
                                       {lit(250, 6, 5, 15), 3},
                                       // The speed falls to a fourth below the second step, and rises again.
                                       {lit(150, 8, 4, 30), 4, {{1.2, 4.0}, {1.6, 27.0}, {kTopMm, 4.0}}}}) {
    for (const auto& facets : {needle(), block(), pyramid()}) {
      CAPTURE(each.lit.curve.penetration_depth.count(), each.lit.dead_zone.count(), each.margin,
              facets.size());
      PrintPlan plan = plan_of(facets, each, bounds_of(each));
      REQUIRE(plan.rises->each.size() == 1);
      const RecordingPrint print(std::move(plan));
      REQUIRE(print.outcome == PrintOutcome::Done);
      CHECK(print.recorded.layers.size() == 40);
      const CureFigures cured = cured_in(facets, print.recorded, each);
      CHECK(cured.tops.missing == 0);
      CHECK(cured.tops.median_um == Approx(0).margin(kTopTolerance_um));
      CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um));
    }
  }
}

TEST_CASE("Level tops of a rise end at their height when speed and light change while it prints") {
  const RiseCase each{lit(150, 8, 4, 30), 4};
  PrintPlan plan = plan_of(pyramid(), each, bounds_of(each));
  plan.rises->settings = planned_settings(plan.rises->bounds);
  std::vector<std::pair<double, RiseSettings>> changes(4, {0.0, plan.rises->settings});
  // The speed falls below the first top, the light below the second one, and both come back below the third.
  changes[0].first = 0.75;
  changes[0].second.speed_mm_h = 15;
  changes[1].first = 1.35;
  changes[1].second.speed_mm_h = 60;
  changes[2].first = 1.45;
  changes[2].second.light_percent = 40;
  changes[3].first = 1.93;
  std::vector<std::string> refusals;
  const RecordingPrint print(
      std::move(plan), testing::small_printer(), [&](ContinuousPrint& process, Nanometers plate) {
        if (changes.empty() || in_mm(plate) < changes.front().first) return;
        const auto changed = change_rises(process.rises_ahead().value(), changes.front().second);
        if (const auto* const refusal = std::get_if<std::string>(&changed))
          refusals.push_back(*refusal);
        else
          process.change(std::get<ChangedRises>(changed));
        changes.erase(changes.begin());
      });
  REQUIRE(print.outcome == PrintOutcome::Done);
  CHECK(refusals.empty());
  CHECK(changes.empty());
  const CureFigures cured = cured_in(pyramid(), print.recorded, each);
  CHECK(cured.tops.missing == 0);
  // The plate stops in the light for each change, and masks then change by no more than 6 um a refresh.
  CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um + 2));
}

// Pauses a print once, in the middle of its rise.
RecordingPrint::AtHeight pause_in_the_middle() {
  return [paused = false](ContinuousPrint& process, Nanometers plate) mutable {
    if (in_mm(plate) < 1.25 || std::exchange(paused, true)) return;
    process.pause();
  };
}

TEST_CASE("After a pause within a rise, tops above the gap end at their height") {
  const RiseCase each{lit(150, 8, 4, 30), 4};
  const RecordingPrint print(plan_of(pyramid(), each, bounds_of(each)), testing::small_printer(),
                             pause_in_the_middle());
  REQUIRE(print.outcome == PrintOutcome::Done);
  REQUIRE(print.pauses == 1);
  CHECK(std::ranges::count(print.recorded.frames, true, &FrameRecord::begins) == 2);
  for (const double memory : {0.0, 1.0}) {
    const CureFigures cured = cured_in(pyramid(), print.recorded, each, memory);
    CHECK(cured.tops.missing == 0);
    CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um));
    CHECK(cured.undersides.missing == 0);
  }
}

TEST_CASE("Masks catch up with the resin after a pause in a rise that is as fast as masks allow") {
  const RiseCase each{lit(150, 8, 31, 30), 4};
  REQUIRE(cure_speed(each.lit, each.margin).count() == Approx(0.12).margin(0.002));
  const RecordingPrint print(plan_of(pyramid(), each, bounds_of(each)), testing::small_printer(),
                             pause_in_the_middle());
  REQUIRE(print.outcome == PrintOutcome::Done);
  REQUIRE(print.pauses == 1);
  const CureFigures cured = cured_in(pyramid(), print.recorded, each, 0);
  CHECK(cured.tops.missing == 0);
  CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um));
}

TEST_CASE("The top ends at its height when the margin grows while the plate goes on above it") {
  const RiseCase each{lit(150, 8, 15, 30), 2};
  PrintPlan plan = plan_of(needle(), each, bounds_of(each));
  plan.rises->settings = planned_settings(plan.rises->bounds);
  bool asked = false, changed = false;
  const RecordingPrint print(std::move(plan), testing::small_printer(),
                             [&](ContinuousPrint& process, Nanometers plate) {
                               // The gap of the new margin is 50 um.
                               if (in_mm(plate) < kTopMm + 0.06 || std::exchange(asked, true)) return;
                               RiseSettings settings = process.settings().rise;
                               settings.margin = 8;
                               const auto rises = change_rises(process.rises_ahead().value(), settings);
                               changed = std::holds_alternative<ChangedRises>(rises);
                               if (changed) process.change(std::get<ChangedRises>(rises));
                             });
  REQUIRE(print.outcome == PrintOutcome::Done);
  REQUIRE(changed);
  const CureFigures cured = cured_in(needle(), print.recorded, each);
  CHECK(cured.tops.missing == 0);
  // The plate stops in the light for the change, and masks then are a refresh behind, 6 um.
  CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um + 6));
}

TEST_CASE("A model that ends at the end of the travel lacks the gap at its top, and nothing is too much") {
  const RiseCase each{lit(150, 8, 4, 30), 4};
  for (const std::int64_t above_nm : {0, 40'000}) {
    SimulatedPrinterConfig config = testing::small_printer();
    config.axis.travel = Nanometers{2'000'000 + above_nm};
    config.axis.start_height = Nanometers{1'000'000};
    RiseBounds bounds = bounds_of(each);
    bounds.travel = config.axis.travel;
    const RecordingPrint print(plan_of(needle(), each, bounds), config);
    REQUIRE(print.outcome == PrintOutcome::Done);
    CHECK(print.recorded.layers.size() == 40);
    const double lacking_um = gel_gap(each.lit, each.margin).count() - static_cast<double>(above_nm) / 1000;
    CHECK(cured_in(needle(), print.recorded, each).tops.median_um ==
          Approx(-lacking_um).margin(kTopTolerance_um));
  }
}

TEST_CASE("A part holds together, and its tops end at their height, where layers or a rest follow a rise") {
  const RiseCase each{lit(150, 8, 4, 30), 4};
  // A step of 1.473 mm, just beneath the end of the first rise.
  SECTION("layers") {
    PrintPlan plan =
        plan_of(pyramid(), {each.lit, each.margin, {{1.5, 4.0}, {kTopMm, 100.0}}}, bounds_of(each));
    REQUIRE(plan.rises->each.back().plan.points.back().height == Nanometers{1'500'000});
    const RecordingPrint print(std::move(plan));
    REQUIRE(print.outcome == PrintOutcome::Done);
    CHECK(print.recorded.layers.size() == 40);
    const CureFigures cured = cured_in(pyramid(), print.recorded, each, 0);
    CHECK(cured.tops.missing == 0);
    // The top of the last layer lacks the dead zone, as in every layered print.
    CHECK(std::max(std::abs(cured.tops.worst_um), 30.0) == Approx(30).margin(kTopTolerance_um));
    CHECK(cured.undersides.places == 0);
    CHECK(cured.undersides.missing == 0);
  }
  SECTION("rest") {
    RiseBounds bounds = bounds_of(each);
    bounds.window = std::chrono::seconds{92};
    PrintPlan plan = plan_of(pyramid(), each, bounds);
    REQUIRE(plan.rises->each.size() == 2);
    REQUIRE(plan.rises->each.front().plan.points.back().height == Nanometers{1'500'000});
    const RecordingPrint print(std::move(plan));
    REQUIRE(print.outcome == PrintOutcome::Done);
    CHECK(print.recorded.layers.size() == 40);
    // The part would stand on the window at the height at which the first rise has gelled.
    const std::vector<FrameRecord>& frames = print.recorded.frames;
    const auto second = std::ranges::find_if(frames.begin() + 1, frames.end(), &FrameRecord::begins);
    REQUIRE(second != frames.end());
    CHECK(second->first >= std::prev(second)->last - Nanometers{2'000});
    const CureFigures cured = cured_in(pyramid(), print.recorded, each, 0);
    CHECK(cured.tops.missing == 0);
    CHECK(cured.tops.worst_um == Approx(0).margin(kTopTolerance_um));
    CHECK(cured.undersides.missing == 0);
  }
}
