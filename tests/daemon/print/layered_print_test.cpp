#include "daemon/print/layered_print.hpp"

#include <filesystem>
#include <tuple>

#include "core/mask/picture_solid.hpp"
#include "daemon/print/layer_durations.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/models/models.hpp"
#include "tests/time_limit.hpp"

namespace {

// A simulated printer with a print process, driven one clock callback at a time.
class LayeredPrintFixture final : public PrintObserver {
 public:
  explicit LayeredPrintFixture(const SimulatedPrinterConfig& config = testing::small_printer())
      : machine(clock, config), process(machine, clock, *this) {
    machine.on_event([this](const MachineEvent& event) {
      if (event.kind == MachineEvent::Kind::Interlock) process.interrupt(event.what);
      if (event.kind == MachineEvent::Kind::Fault) process.fail(event.what);
    });
  }

  void start(int count = 3) { process.start(testing::box_plan(count)); }

  // Runs the clock until the state is reached; returns false if the print ends before.
  bool run_to(LayeredState state) {
    while (process.layered_state() != state) {
      if (!step()) return false;
    }
    return true;
  }
  bool run_to_light() {
    while (!machine.light_is_on()) {
      if (!step()) return false;
    }
    return true;
  }
  void run_out() {
    while (step()) {
    }
  }

  void light_due() override {}
  void state_changed(const PrintState&) override { states.push_back(process.layered_state()); }
  void layer_done(const LayerRecord& layer) override { layers.push_back(layer); }
  void interrupted(const std::string& what) override { interruptions.push_back(what); }
  void light_gone() override { gone_while_lit = gone_while_lit || machine.light_is_on(); }
  void print_ended(PrintOutcome ended, const std::string& why, PrintPlan) override {
    ends.push_back(ended);
    reason = why;
    light_at_end = machine.light_is_on();
  }

  VirtualClock clock;
  SimulatedPrinter machine;
  std::vector<LayeredState> states;
  std::vector<LayerRecord> layers;
  std::vector<std::string> interruptions;
  std::vector<PrintOutcome> ends;
  std::string reason;
  bool light_at_end = false;
  bool gone_while_lit = false;
  bool lit_unknown = false;  // light on while the process reports it as off
  bool lit_wrongly = false;  // light on outside an exposure, or over a black screen
  LayeredPrint process;

 private:
  bool step() {
    const bool more = clock.run_next();
    const bool may_be_lit = process.layered_state() == LayeredState::Igniting ||
                            process.layered_state() == LayeredState::Exposing;
    lit_unknown = lit_unknown || (machine.light_is_on() && !process.light_may_be_on());
    lit_wrongly = lit_wrongly || (machine.light_is_on() && (!may_be_lit || machine.screen_is_black()));
    return more;
  }
};

using S = LayeredState;

constexpr LayeredState kActiveStates[] = {
    S::WarmingUp, S::Homing,        S::Lowering,     S::Settling, S::Showing, S::Igniting,     S::Exposing,
    S::Darkening, S::Extinguishing, S::Interrupting, S::Resting,  S::Lifting, S::AwaitingDark, S::Raising,
    S::Paused,    S::Held,          S::Braking,      S::Halting,  S::Parking, S::Ending};

// Brings a print into a state.
void bring_to(LayeredPrintFixture& fixture, LayeredState state) {
  fixture.start();
  if (state == S::Raising || state == S::Paused) fixture.process.pause();
  if (state == S::Held) fixture.process.interrupt("the lid was opened");
  if (state == S::Interrupting) {
    REQUIRE(fixture.run_to(S::Exposing));
    fixture.process.interrupt("the lid was opened");
  }
  if (state == S::Braking) {
    REQUIRE(fixture.run_to(S::Lowering));
    fixture.process.interrupt("the lid was opened");
  }
  if (state == S::Halting) {
    REQUIRE(fixture.run_to(S::Lifting));
    fixture.process.cancel();
  }
  REQUIRE(fixture.run_to(state));
}

// Returns the plan for a box whose layers are lifted and lowered in two stages.
PrintPlan staged_plan(int layers) {
  PrintPlan plan = testing::box_plan(layers);
  plan.motion.lift = Nanometers{2'000'000};
  plan.motion.second_lift = Nanometers{3'000'000};
  plan.motion.second_lift_speed = MillimetersPerSecond{4};
  plan.motion.slow_retract = Nanometers{500'000};
  plan.motion.slow_retract_speed = MillimetersPerSecond{1};
  return plan;
}

// Returns the plan for a box above which the plate comes down so slowly that a layer's thickness takes a
// second.
PrintPlan slow_plan(int layers) {
  PrintPlan plan = staged_plan(layers);
  plan.motion.slow_retract = plan.motion.whole_lift();
  plan.motion.slow_retract_speed = MillimetersPerSecond{in_mm(kBoxLayer)};
  return plan;
}

// Returns the plan for a box whose layers press resin out of the gap, 0.9 s long, and the plate for 2 s.
PrintPlan pressing_plan(int layers) {
  PrintPlan plan = testing::box_plan(layers);
  MaskBudget budget(MaskBudget::Clock::now() + testing::kTimeLimit);
  REQUIRE(plan.engine->mask_within(kBoxLayer / 2, budget) != nullptr);
  const double shape_mm4 = press_shape_mm4(plan.engine->coverage(), testing::kSmallDisplay.pixel_pitch);
  plan.pressed = PressedResin{0.9 / press_time({1, 1}, shape_mm4, kBoxLayer).count(), 1};
  plan.plate_shape_mm4 = 2 / 0.9 * shape_mm4;
  plan.expected_shapes.assign(static_cast<std::size_t>(layers), shape_mm4);
  return plan;
}

// Returns the plan for a box on a display without grey that gives each pixel a share of its light: a quarter
// to the pixels on the left, all to those on the right.
PrintPlan split_plan(int layers) {
  PrintPlan plan = testing::box_plan(layers);
  const DisplayGeometry& display = testing::kSmallDisplay;
  Mask uniformity(display.width, display.height);
  for (std::int32_t y = 0; y < display.height.count(); ++y)
    for (std::size_t x = 0; x < uniformity.row(y).size(); ++x)
      uniformity.row(y)[x] = x < uniformity.row(y).size() / 2 ? 64 : 255;
  std::vector<PlateModel> models(plan.engine->models().begin(), plan.engine->models().end());
  plan.engine = std::make_unique<ContourEngine>(
      std::move(models), EngineSettings{.display = display, .uniformity = std::move(uniformity)});
  plan.split = std::make_unique<SplitExposure>(PanelTone{1, 3}, display.width, display.height);
  return plan;
}

// No sections, whose cuts are counted.
class CountedSections final : public SectionSource {
 public:
  void section_at(Nanometers, Contours& contours) const override {
    ++cuts_;
    contours = Contours{};
  }
  [[nodiscard]] int cuts() const { return cuts_; }

 private:
  mutable int cuts_ = 0;
};

// Returns the plan for a box of three layers whose undersides are dimmed.
PrintPlan dimmed_plan(Duration mask_budget, std::shared_ptr<const SectionSource> supports) {
  PrintPlan plan = testing::box_plan(3);
  const WorkingCurve resin{Micrometers{150}, MillijoulesPerCm2{8}};
  UndersideCure cure{.layers = {}, .resin = {.curve = resin}, .mask_budget = mask_budget};
  for (int layer = 1; layer <= 3; ++layer)
    cure.layers.push_back({testing::kBoxLayer * layer, testing::kBoxLayer, MillijoulesPerCm2{16}});
  const EngineSettings settings{.display = testing::kSmallDisplay};
  plan.undersides = std::make_unique<DimmedMasks>(
      std::make_unique<UndersideDimming>(plan.engine->models(), std::move(supports), settings, cure),
      ToneCurve{}, std::nullopt);
  return plan;
}

}  // namespace

TEST_CASE("Homing at the slowest speed over the whole travel does not time out") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.axis.homing_speed = MillimetersPerSecond{0.1};
  config.axis.start_height = config.axis.travel;
  LayeredPrintFixture fixture(config);
  PrintPlan plan = testing::box_plan(1);
  plan.homing_speed = config.axis.homing_speed;
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.reason.empty());
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A print goes through its states layer by layer and ends parked, done and dark") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  fixture.run_out();
  const std::vector<S> layer{S::Lowering,  S::Settling,      S::Showing, S::Igniting, S::Exposing,
                             S::Darkening, S::Extinguishing, S::Resting, S::Lifting,  S::AwaitingDark};
  std::vector<S> expected{S::WarmingUp, S::Homing, S::AwaitingDark};
  for (int i = 0; i < 2; ++i)
    expected.insert(expected.end(), layer.begin(), layer.end());
  expected.insert(expected.end(), {S::Parking, S::Ending, S::Idle});
  CHECK(fixture.states == expected);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(fixture.lit_wrongly);
  CHECK_FALSE(fixture.light_at_end);
  CHECK(fixture.machine.z_axis().height() == fixture.machine.z_axis().travel());
}

TEST_CASE("The plate rises in two stages, and comes down slowly at the end") {
  LayeredPrintFixture fixture;
  fixture.process.start(staged_plan(2));
  const ZAxis& axis = fixture.machine.z_axis();
  const LayerMotion motion = staged_plan(2).motion;
  const auto check = [&](S state, Nanometers first, MillimetersPerSecond first_speed, Nanometers second,
                         MillimetersPerSecond second_speed) {
    INFO(name_of(state));
    REQUIRE(fixture.run_to(state));
    const TimePoint start = fixture.clock.now();
    const Nanometers from = axis.height().value();
    const Duration first_duration = axis.move_duration(first, first_speed);
    const Duration duration = first_duration + axis.move_duration(second, second_speed);
    CHECK(fixture.process.state_left() == duration);
    std::optional<Nanometers> between;
    const auto look = fixture.clock.call_at(start + first_duration, [&] { between = axis.height(); });
    while (fixture.process.layered_state() == state)
      REQUIRE(fixture.clock.run_next());
    CHECK(fixture.clock.now() - start == duration);
    CHECK(between == from + first);
    CHECK(axis.height() == from + first + second);
  };
  check(S::Lifting, motion.lift, motion.lift_speed, motion.second_lift, motion.second_lift_speed);
  check(S::Lowering, kBoxLayer + motion.slow_retract - motion.whole_lift(), motion.retract_speed,
        -motion.slow_retract, motion.slow_retract_speed);
}

TEST_CASE("The wait before the light is as long as the face before presses out resin") {
  LayeredPrintFixture fixture;
  fixture.process.start(pressing_plan(3));
  for (int layer = 0; layer < 3; ++layer) {
    REQUIRE(fixture.run_to(S::Settling));
    const TimePoint start = fixture.clock.now();
    REQUIRE(fixture.run_to(S::Showing));
    const std::chrono::duration<double> waited = fixture.clock.now() - start;
    CHECK(waited.count() == contourd::testing::Approx(layer == 0 ? 2.0 : 0.9).epsilon(1e-6));
    REQUIRE(fixture.run_to(S::Lowering) == (layer < 2));
  }
  REQUIRE(fixture.layers.size() == 3);
  CHECK(fixture.layers[0].settling > fixture.layers[1].settling);
}

TEST_CASE("The wait before the light is at least that of the profile, and at most a minute") {
  PrintPlan plan = pressing_plan(1);
  CHECK(settling_duration(plan, 0, kBoxLayer) == plan.motion.settle);
  CHECK(settling_duration(plan, 1e300, kBoxLayer) == kLongestSettling);
  CHECK(settling_duration(plan, plan.plate_shape_mm4, kBoxLayer * 2) == plan.motion.settle);  // an eighth
  plan.pressed.reset();
  CHECK(settling_duration(plan, 1e300, kBoxLayer) == plan.motion.settle);
}

TEST_CASE("A move that is stopped in either stage does not go on with the other") {
  const bool in_second = GENERATE(false, true);
  const auto state = GENERATE(S::Lifting, S::Lowering);
  CAPTURE(in_second, state);
  LayeredPrintFixture fixture;
  fixture.process.start(staged_plan(3));
  REQUIRE(fixture.run_to(S::Exposing));
  REQUIRE(fixture.run_to(state));
  const Duration whole = fixture.process.state_left().value();
  const auto stop = fixture.clock.call_after(in_second ? whole - 100ms : 100ms, [&] {
    REQUIRE(fixture.process.layered_state() == state);
    fixture.process.cancel();
  });
  REQUIRE(fixture.run_to(S::Parking));
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
  CHECK(fixture.machine.z_axis().height() == fixture.machine.z_axis().travel());
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE("Light may be on from its command until it is confirmed off, and its layer is reported then") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  // The layer has had all its light, which is not confirmed off yet.
  REQUIRE(fixture.run_to(S::Darkening));
  CHECK(fixture.process.light_may_be_on());
  fixture.process.interrupt("the lid was opened");
  CHECK(fixture.process.light_may_be_on());
  CHECK(fixture.layers.empty());
  REQUIRE(fixture.run_to(S::Paused));
  CHECK_FALSE(fixture.process.light_may_be_on());
  REQUIRE(fixture.layers.size() == 1);
  CHECK(fixture.layers[0].loops == 1);
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(fixture.lit_unknown);
  CHECK_FALSE(fixture.gone_while_lit);
}

TEST_CASE("Each layer is exposed for exactly the requested time, at its own height") {
  LayeredPrintFixture fixture;
  fixture.start(3);
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const LayerRecord& layer = fixture.layers[i];
    CHECK(layer.exposure_asked == 1s + 100ms * static_cast<int>(i));
    CHECK(layer.exposure_most == layer.exposure_asked);
    CHECK(layer.plate_height == testing::kBoxLayer * static_cast<std::int64_t>(i + 1));
    CHECK(layer.mask_height == layer.plate_height - testing::kBoxLayer / 2);
    // 3 mm x 2 mm at 0.1 mm per pixel are whole pixels, so the area is exact.
    CHECK(layer.area_mm2 == contourd::testing::Approx(6.0).epsilon(1e-12));
    CHECK(layer.loops == 1);
    CHECK(layer.intersecting_facets == 8);
    CHECK(layer.cracks == LayerCracks{});
  }
}

TEST_CASE("A layer's record contains the gaps that were closed in its mask") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(2);
  models::Facets cracked = models::box({0, 0, 0}, {3, 2, 0.1F});
  for (Facet& facet : cracked) {
    const auto& v = facet.vertices;
    const bool front = v[0].y == 0 && v[1].y == 0 && v[2].y == 0;
    for (Vertex& vertex : facet.vertices)
      vertex.y -= front ? 0.02F : 0;
  }
  plan.engine =
      std::make_unique<ContourEngine>(HeightIndex(cracked), EngineSettings{.display = testing::kSmallDisplay},
                                      std::vector{PixelMap::true_scale(testing::kSmallDisplay, {1.5, 1})});
  ContourEngine alone(*plan.engine);
  fixture.process.start(std::move(plan));
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 2);
  for (const LayerRecord& layer : fixture.layers) {
    const Contours& contours = alone.contours_at(layer.mask_height);
    CHECK(layer.cracks == contours.cracks);
    CHECK(layer.cracks.gaps_closed == 2);
    CHECK(layer.loops == contours.loops.size());
    CHECK(layer.intersecting_facets == 8);
  }
}

TEST_CASE(
    "Layers of different thickness are stacked without gaps, each with the exposure for its thickness") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(1);
  // A cone with its point up on a block: slopes of 45 degrees.
  auto model = std::make_shared<const HeightIndex>(models::cone(2, 2, 64));
  plan.engine = std::make_unique<ContourEngine>(
      std::vector{PlateModel{{model}, {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})}}},
      EngineSettings{testing::kSmallDisplay, AntiAliasing::On});
  plan.layers =
      PrintLayers({{model}, {std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 3}))}},
                  {Nanometers{20'000}, Nanometers{100'000}, Nanometers{35'000}});
  plan.expected_layers = plan.layers.all();
  plan.exposure = [](std::int32_t, Nanometers thickness) { return thickness.count() * 10us; };
  const std::vector<Nanometers> expected = plan.expected_layers;
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  REQUIRE(fixture.layers.size() == expected.size());
  Nanometers bottom{};
  std::set<Nanometers> thicknesses;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const LayerRecord& layer = fixture.layers[i];
    CHECK(layer.bottom == bottom);
    CHECK(layer.thickness == expected[i]);
    CHECK(layer.exposure_most == layer.thickness.count() * 10us);
    bottom += layer.thickness;
    // The simulated axis rounds to its microstep of 1.25 um: by at most half of it.
    CHECK(std::abs((layer.plate_height - bottom).count()) <= 625);
    CHECK(layer.mask_height == layer.plate_height - layer.thickness / 2);
    thicknesses.insert(layer.thickness);
  }
  CHECK(bottom == Nanometers{3'000'000});
  // On the slope, layers are 35 um / cos 45 degrees thick; above it they have the largest thickness.
  CHECK(thicknesses.contains(Nanometers{49'000}));
  CHECK(thicknesses.contains(Nanometers{100'000}));
}

TEST_CASE("A print with more layers than expected continues and ends after its last layer") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(3);
  plan.expected_layers.resize(1);
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to(S::Lifting));
  const ZAxis& axis = fixture.machine.z_axis();
  CHECK(fixture.process.time_left() <= axis.move_duration(axis.travel(), MillimetersPerSecond{5}) + 3s);
  fixture.run_out();
  CHECK(fixture.layers.size() == 3);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("The mask belongs to the plate's actual height, not to the requested height") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.axis.microsteps_per_mm = 30;  // steps of 33 um: no layer of 50 um falls on one
  LayeredPrintFixture fixture(config);
  fixture.start(3);
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 3);
  CHECK(fixture.layers[0].plate_height == Nanometers{66'667});
  for (const LayerRecord& layer : fixture.layers)
    CHECK(layer.mask_height == layer.plate_height - testing::kBoxLayer / 2);
}

TEST_CASE("Each layer of finished pictures shows its own picture, wherever the plate really is") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.axis.microsteps_per_mm = 10;  // steps of two layers
  LayeredPrintFixture fixture(config);
  constexpr int kLayers = 4;
  auto pictures = std::make_shared<PictureStack>(testing::kSmallDisplay.width, testing::kSmallDisplay.height,
                                                 testing::kBoxLayer);
  Mask picture(pictures->width(), pictures->height());
  for (int layer = 0; layer < kLayers; ++layer) {
    picture.row(layer)[7] = 255;  // a pixel more in each layer
    pictures->add(picture);
  }
  PlateModel model{{std::make_shared<const HeightIndex>(box_of(*pictures, testing::kSmallDisplay))},
                   {PixelMap::true_scale(testing::kSmallDisplay, {0, 0})}};
  model.pictures = pictures;
  PrintPlan plan = testing::box_plan(kLayers);
  plan.engine =
      std::make_unique<ContourEngine>(std::vector{model}, EngineSettings{.display = testing::kSmallDisplay});
  fixture.process.start(std::move(plan));
  fixture.run_out();
  REQUIRE(fixture.layers.size() == kLayers);
  CHECK(fixture.layers[0].plate_height == Nanometers{100'000});
  for (std::size_t layer = 0; layer < kLayers; ++layer) {
    CHECK(fixture.layers[layer].mask_height ==
          testing::kBoxLayer * static_cast<std::int64_t>(layer) + testing::kBoxLayer / 2);
    CHECK(std::llround(fixture.layers[layer].area_mm2 / 0.01) == static_cast<std::int64_t>(layer + 1));
  }
}

TEST_CASE("A failure in any state turns the light off, leaves the motor still and ends the print once") {
  for (const S state : kActiveStates) {
    CAPTURE(name_of(state));
    LayeredPrintFixture fixture;
    bring_to(fixture, state);
    fixture.process.fail("the sky fell");
    CHECK_FALSE(fixture.machine.light_is_on());
    CHECK(fixture.machine.screen_is_black());
    CHECK_FALSE(fixture.machine.z_axis().moving());
    CHECK(fixture.process.layered_state() == S::Ending);
    fixture.run_out();  // late answers from the machine change nothing
    CHECK(fixture.process.layered_state() == S::Idle);
    REQUIRE(fixture.ends.size() == 1);
    CHECK_FALSE(fixture.machine.light_is_on());
    if (state == S::Ending) continue;  // the print had been completed
    CHECK(fixture.ends[0] == PrintOutcome::Failed);
    CHECK(fixture.reason == "the sky fell");
  }
}

TEST_CASE(
    "A cancel in any state turns the light off at once and moves the plate up if its position is known") {
  for (const S state : kActiveStates) {
    if (state == S::Halting || state == S::Parking || state == S::Ending)
      continue;  // cancelled or done already
    CAPTURE(name_of(state));
    LayeredPrintFixture fixture;
    bring_to(fixture, state);
    fixture.process.cancel();
    CHECK_FALSE(fixture.machine.light_is_on());
    CHECK(fixture.machine.screen_is_black());
    fixture.run_out();
    CHECK(fixture.process.layered_state() == S::Idle);
    CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
    CHECK_FALSE(fixture.lit_wrongly);
    const bool position_known = state != S::WarmingUp && state != S::Homing && state != S::Held;
    if (position_known) CHECK(fixture.machine.z_axis().height() == fixture.machine.z_axis().travel());
  }
}

TEST_CASE("A print that is cancelled after its last layer still counts as done") {
  LayeredPrintFixture fixture;
  bring_to(fixture, S::Parking);
  fixture.process.cancel();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE(
    "A pause waits for the layer under way and lifts the plate, and a resume continues with the next layer") {
  LayeredPrintFixture fixture;
  fixture.start(3);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.pause();
  CHECK(fixture.process.pause_pending());
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 1);
  CHECK(fixture.layers[0].exposure_most == fixture.layers[0].exposure_asked);
  // The layer's height, the lift, and 30 mm for looking at the part.
  CHECK(fixture.machine.z_axis().height() == Nanometers{36'050'000});
  fixture.run_out();
  CHECK(fixture.process.layered_state() == S::Paused);
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.layers.size() == 3);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE(
    "A planned pause begins before its layer, or at its height, and the print then goes on to its end") {
  const auto layers_at_pause = [](PausePoint point) {
    LayeredPrintFixture fixture;
    fixture.start(5);
    fixture.process.pause_at(point);
    CHECK_FALSE(fixture.process.pause_pending());
    CHECK(fixture.process.planned_pause() == point);
    const bool paused = fixture.run_to(S::Paused);
    CHECK_FALSE((paused && fixture.process.planned_pause()));
    const std::size_t done = fixture.layers.size();
    fixture.process.resume();
    fixture.run_out();
    CHECK(fixture.layers.size() == 5);
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
    return done;
  };
  CHECK(layers_at_pause(1) == 1);
  CHECK(layers_at_pause(3) == 3);
  CHECK(layers_at_pause(4) == 4);
  CHECK(layers_at_pause(5) == 5);  // beyond the last layer: the print ends
  CHECK(layers_at_pause(kBoxLayer * 2) == 2);
  CHECK(layers_at_pause(kBoxLayer * 2 + Nanometers{1}) == 3);
}

TEST_CASE("A planned pause is withdrawn by a resume of the running print or by another pause") {
  LayeredPrintFixture fixture;
  fixture.start(5);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.pause_at(2);
  CHECK(fixture.process.can_resume());
  fixture.process.resume();
  CHECK_FALSE(fixture.process.planned_pause());
  CHECK_FALSE(fixture.process.can_resume());
  fixture.process.pause_at(2);
  fixture.process.pause();
  CHECK_FALSE(fixture.process.planned_pause());
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 1);
  fixture.process.resume();
  CHECK_FALSE(fixture.run_to(S::Paused));
}

TEST_CASE("A planned pause survives an interruption, and comes once if its layer was interrupted") {
  LayeredPrintFixture fixture;
  fixture.start(5);
  fixture.process.pause_at(2);
  for (const S state : {S::Exposing, S::Resting, S::Lifting, S::AwaitingDark}) {
    CAPTURE(static_cast<int>(state));
    REQUIRE(fixture.run_to(state));
    fixture.process.interrupt("the lid was opened");
    REQUIRE(fixture.run_to(S::Paused));
    fixture.process.resume();
    CHECK(fixture.process.planned_pause().has_value() == (fixture.layers.size() < 2));
  }
  fixture.run_out();
  CHECK(fixture.layers.size() == 5);
}

TEST_CASE("A planned pause for the layer after which the print is paused already does not pause it again") {
  LayeredPrintFixture fixture;
  fixture.start(3);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.pause();
  REQUIRE(fixture.run_to(S::Paused));
  fixture.process.pause_at(1);
  fixture.process.resume();
  CHECK_FALSE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 3);
}

TEST_CASE("Changed settings hold from the next layer on, and the time left follows them") {
  LayeredPrintFixture fixture;
  fixture.start(4);
  REQUIRE(fixture.run_to(S::Exposing));
  const Duration before = fixture.process.time_left();
  PrintSettings settings = fixture.process.settings();
  CHECK(settings.exposure_percent == 100);
  settings = with_value(with_value(settings, "exposure", 50), "rest", 1300);
  fixture.process.set(settings);
  CHECK(fixture.process.settings().motion.rest == std::chrono::milliseconds{1300});
  // Three layers rest a second longer, and have half of 1.1, 1.2 and 1.3 s of light.
  CHECK(before - fixture.process.time_left() == std::chrono::milliseconds{1800 - 3000});
  const auto at_set = fixture.clock.now();
  const Duration expected = fixture.process.time_left();
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 4);
  CHECK(fixture.layers[0].exposure_asked == std::chrono::milliseconds{1000});
  CHECK(fixture.layers[1].exposure_asked == std::chrono::milliseconds{550});
  CHECK(fixture.layers[3].exposure_most == std::chrono::milliseconds{650});
  CHECK(std::chrono::abs(fixture.clock.now() - at_set - expected) < std::chrono::milliseconds{200});
}

TEST_CASE("Settings changed in an interrupted layer leave the rest of its light as planned") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.interrupt("the lid was opened");
  REQUIRE(fixture.run_to(S::Paused));
  fixture.process.set(with_value(fixture.process.settings(), "exposure", 200));
  fixture.process.resume();
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 2);
  CHECK(fixture.layers[0].exposure_asked == std::chrono::milliseconds{1000});
  CHECK(fixture.layers[0].exposure_most >= std::chrono::milliseconds{1000});
  CHECK(fixture.layers[0].exposure_most < std::chrono::milliseconds{1100});
  CHECK(fixture.layers[1].exposure_asked == std::chrono::milliseconds{2200});
}

TEST_CASE("A changed lift moves the plate as far as it says") {
  LayeredPrintFixture fixture;
  fixture.start(3);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.set(with_value(fixture.process.settings(), "lift", 3));
  REQUIRE(fixture.run_to(S::AwaitingDark));
  CHECK(fixture.machine.z_axis().height() == Nanometers{6'050'000});
  REQUIRE(fixture.run_to(S::Lowering));
  REQUIRE(fixture.run_to(S::AwaitingDark));
  CHECK(fixture.machine.z_axis().height() == Nanometers{3'100'000});
}

TEST_CASE("An excluded copy is dark from the next layer on, and its area is no longer exposed") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(4);
  const auto model = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 0.2F}));
  const DisplayGeometry& display = testing::kSmallDisplay;
  plan.engine = std::make_unique<ContourEngine>(
      std::vector{PlateModel{
          {model}, {PixelMap::true_scale(display, {2, 0.5}), PixelMap::true_scale(display, {-1, 0.5})}}},
      EngineSettings{.display = display});
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to(S::Exposing));
  REQUIRE(fixture.run_to(S::Lifting));
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.exclude({0, 1, {}});
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 4);
  for (const LayerRecord& layer : fixture.layers)
    CHECK(layer.area_mm2 == Approx(layer.layer < 2 ? 2 : 1));
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A dry run makes all moves and masks in the time of the print, and never turns the light on") {
  const auto run = [](bool dry) {
    LayeredPrintFixture fixture;
    PrintPlan plan = testing::box_plan(3);
    plan.dry = dry;
    fixture.process.start(std::move(plan));
    std::size_t masks = 0;
    const bool lit = fixture.run_to_light();
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
    const TimePoint end = fixture.clock.now();
    REQUIRE(fixture.layers.size() == 3);
    for (const LayerRecord& layer : fixture.layers) {
      CHECK(layer.complete == !dry);
      CHECK((layer.exposure_most == Duration{0}) == dry);
      CHECK(layer.area_mm2 > 5);
      masks += layer.shown_at > TimePoint{} ? 1U : 0U;
    }
    CHECK(masks == 3);
    return std::tuple(lit, end, fixture.states);
  };
  const auto [lit, end, states] = run(false);
  const auto [dry_lit, dry_end, dry_states] = run(true);
  CHECK(lit);
  CHECK_FALSE(dry_lit);
  CHECK(std::chrono::abs(end - dry_end) <
        std::chrono::milliseconds{500});  // refreshes and the lamp's replies
  CHECK(states == dry_states);
}

TEST_CASE("A dry run can be interrupted in an exposure, resumed and cancelled, in the dark") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(3);
  plan.dry = true;
  fixture.process.start(std::move(plan));
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.process.interrupt("the lid was opened");
  REQUIRE(fixture.run_to(S::Paused));
  fixture.process.resume();
  REQUIRE(fixture.run_to(S::Resting));
  fixture.process.cancel();
  CHECK_FALSE(fixture.run_to_light());
  CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
}

TEST_CASE("Every state reports when a pause takes effect, or none if the print ends before") {
  const auto next_pause_in = [](LayeredState state) {
    LayeredPrintFixture fixture;
    bring_to(fixture, state);
    return std::string(fixture.process.next_pause());
  };
  for (const S state : {S::WarmingUp, S::Homing})
    CHECK(next_pause_in(state) == "before the first layer");
  for (const S state : {S::Lowering, S::Settling, S::Showing, S::Igniting, S::Exposing, S::Darkening,
                        S::Extinguishing, S::Resting, S::Lifting})
    CHECK(next_pause_in(state) == "after this layer");
  for (const S state : {S::Raising, S::Paused, S::Held})
    CHECK(next_pause_in(state) == "now");
  for (const S state : {S::Interrupting, S::Braking})
    CHECK(next_pause_in(state) == "when the plate is up");
  for (const S state : {S::Halting, S::Parking, S::Ending})
    CHECK(next_pause_in(state).empty());
}

TEST_CASE("A print of one layer can be paused before the layer but not during it") {
  LayeredPrintFixture fixture;
  fixture.start(1);
  REQUIRE(fixture.run_to(S::Homing));
  CHECK(fixture.process.next_pause() == "before the first layer");
  REQUIRE(fixture.run_to(S::Exposing));
  CHECK(fixture.process.next_pause().empty());
  fixture.process.interrupt("the lid was opened");
  CHECK(fixture.process.next_pause() == "when the plate is up");
  REQUIRE(fixture.run_to(S::Paused));
}

TEST_CASE("A resume while the plate still moves up for a pause takes effect as soon as it is up") {
  LayeredPrintFixture fixture;
  bring_to(fixture, S::Raising);
  fixture.process.resume();
  fixture.run_out();
  CHECK(std::count(fixture.states.begin(), fixture.states.end(), S::Paused) == 1);
  CHECK(fixture.layers.size() == 3);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A resume before a pause has taken effect withdraws the pause") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  fixture.process.pause();
  fixture.process.resume();
  fixture.run_out();
  CHECK(std::count(fixture.states.begin(), fixture.states.end(), S::Paused) == 0);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A limit switch that never closes ends the print with a reason that names it") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.axis.limit_switch = SimulatedAxisConfig::Switch::StuckOpen;
  LayeredPrintFixture fixture(config);
  fixture.start();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
  CHECK(fixture.reason == "homing failed: the limit switch did not trigger after the full travel");
}

TEST_CASE(
    "A display lost during the print pauses it in the dark, with the plate up, until the user resumes") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.display.lost_after_frames = 1;
  LayeredPrintFixture fixture(config);
  fixture.start();
  fixture.run_out();
  CHECK(fixture.process.layered_state() == S::Paused);
  CHECK(fixture.process.interruption() == "the display was unplugged");
  CHECK(fixture.machine.why_not_ready() == "the display is unplugged");
  CHECK(fixture.layers.size() == 1);
  CHECK_FALSE(fixture.machine.light_is_on());
  // Two layers, the lift, and 30 mm for looking at the part.
  CHECK(fixture.machine.z_axis().height() == Nanometers{36'100'000});
  fixture.machine.plug_display();
  CHECK(fixture.process.layered_state() == S::Paused);
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK(fixture.layers.size() == 3);
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE("A print resumed while the display is still gone exposes nothing and pauses again") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.display.lost_after_frames = 1;
  LayeredPrintFixture fixture(config);
  fixture.start();
  fixture.run_out();
  fixture.process.resume();
  CHECK(fixture.process.interruption().empty());
  fixture.run_out();
  CHECK(fixture.process.layered_state() == S::Paused);
  CHECK(fixture.process.interruption() == "the display was lost");
  CHECK(fixture.layers.size() == 1);
  fixture.process.cancel();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE(
    "A mask that exceeds its budget is abandoned in the dark, reported with its figures, and computed again "
    "on resume") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(3);
  plan.mask_budget = Duration{0};
  fixture.process.start(std::move(plan));
  for (std::size_t times = 1; times <= 2; ++times) {
    fixture.run_out();
    CHECK(fixture.process.layered_state() == S::Paused);
    REQUIRE(fixture.interruptions.size() == times);
    CAPTURE(fixture.interruptions.back());
    CHECK(fixture.interruptions.back().find("the mask at 0.025 mm was abandoned") == 0);
    CHECK(fixture.interruptions.back().find("mask_budget_ms, 0 ms") != std::string::npos);
    CHECK(fixture.interruptions.back().find("8 facets cut") != std::string::npos);
    CHECK(std::ranges::count(fixture.states, S::Igniting) == 0);
    CHECK(fixture.machine.screen_is_black());
    fixture.process.resume();
  }
  fixture.process.cancel();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Canceled});
  CHECK(fixture.layers.empty());
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE("A layer is recorded as one in which undersides were not found within their budget") {
  LayeredPrintFixture fixture;
  fixture.process.start(dimmed_plan(Duration{0}, nullptr));
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 3);
  CHECK(fixture.layers[0].undersides_found);
  CHECK_FALSE(fixture.layers[1].undersides_found);
  CHECK_FALSE(fixture.layers[2].undersides_found);
}

TEST_CASE("The masks ahead are computed while the plate settles, not between its height and its mask") {
  LayeredPrintFixture fixture;
  const auto supports = std::make_shared<CountedSections>();
  fixture.process.start(dimmed_plan(std::chrono::seconds{60}, supports));
  for (int layer = 0; layer < 3; ++layer) {
    REQUIRE(fixture.run_to(S::Settling));
    const int settling = supports->cuts();
    REQUIRE(fixture.run_to_light());
    CHECK(supports->cuts() == settling);
    REQUIRE(fixture.run_to(layer < 2 ? S::Lowering : S::Parking));
    CHECK(supports->cuts() == settling);
  }
}

TEST_CASE("An interrupted exposure continues with its remaining time, at the same layer") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  REQUIRE(fixture.run_to_light());
  const TimePoint lit = fixture.clock.now();
  const auto opening = fixture.clock.call_at(lit + 400ms, [&] { fixture.machine.open_lid(); });
  while (fixture.machine.light_is_on())
    REQUIRE(fixture.clock.run_next());
  CHECK(fixture.clock.now() == lit + 400ms);
  CHECK(fixture.machine.screen_is_black());
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.process.interruption() == "the lid was opened");
  CHECK(fixture.interruptions == std::vector<std::string>{"the lid was opened"});
  CHECK(fixture.layers.empty());
  CHECK(fixture.process.layer() == 0);
  fixture.machine.close_lid();
  fixture.process.resume();
  REQUIRE(fixture.run_to_light());
  CHECK(fixture.machine.z_axis().height() == testing::kBoxLayer);
  const TimePoint lit_again = fixture.clock.now();
  REQUIRE(fixture.run_to(S::Darkening));
  CHECK(fixture.clock.now() == lit_again + 600ms);
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 2);
  CHECK(fixture.layers[0].exposure_most == 1s);
  CHECK(fixture.layers[0].exposure_parts == 2);
  CHECK(fixture.layers[1].exposure_most == 1100ms);
  CHECK(fixture.layers[1].exposure_parts == 1);
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE(
    "A light that goes off early during an exposure interrupts the exposure, and only the light given "
    "counts") {
  for (const bool reported : {false, true}) {
    LayeredPrintFixture fixture;
    fixture.start(1);
    REQUIRE(fixture.run_to(S::Igniting));
    const auto off = fixture.clock.call_after(300ms, [&] { fixture.machine.projector().light_off(); });
    // The report arrives at the exposure's planned end, before the exposure's own timer.
    const TimePoint end = fixture.machine.projector().last_light().value().on_earliest + 1s;
    const auto report = fixture.clock.call_at(end, [&] {
      if (reported) fixture.process.interrupt("the light watchdog has turned the light off");
    });
    REQUIRE(fixture.run_to(S::Paused));
    CHECK(fixture.interruptions.size() == 1);
    CHECK(fixture.layers.empty());
    fixture.process.resume();
    fixture.run_out();
    REQUIRE(fixture.layers.size() == 1);
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
    CHECK(fixture.layers[0].exposure_parts == 2);
    CHECK(fixture.layers[0].complete);
    // The bounds include the turn of the loop between the light-on command and its reply.
    CHECK(fixture.layers[0].exposure_most - 1s < 1ms);
    CHECK(1s - fixture.layers[0].exposure_least < 1ms);
  }
}

TEST_CASE("An exposure interrupted three times adds up to the requested time") {
  LayeredPrintFixture fixture;
  fixture.start(1);
  for (const Duration until : {100ms, 250ms, 1ms}) {
    REQUIRE(fixture.run_to(S::Exposing));
    const auto opening = fixture.clock.call_after(until, [&] { fixture.machine.open_lid(); });
    REQUIRE(fixture.run_to(S::Paused));
    fixture.process.resume();
  }
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 1);
  CHECK(fixture.layers[0].exposure_most == 1s);
  CHECK(fixture.layers[0].exposure_parts == 4);
}

TEST_CASE(
    "An interruption in any state turns the light off at once, and the print can be finished or cancelled") {
  for (const S state : kActiveStates) {
    for (const bool resumed : {true, false}) {
      CAPTURE(name_of(state), resumed);
      LayeredPrintFixture fixture;
      bring_to(fixture, state);
      fixture.process.interrupt("the cat jumped on it");
      CHECK_FALSE(fixture.machine.light_is_on());
      CHECK(fixture.machine.screen_is_black());
      fixture.run_out();
      CHECK_FALSE(fixture.lit_wrongly);
      if (state == S::Halting || state == S::Parking || state == S::Ending) {
        CHECK(fixture.process.layered_state() == S::Idle);  // was about to end
        continue;
      }
      CHECK((fixture.process.layered_state() == S::Paused || fixture.process.layered_state() == S::Held));
      CHECK_FALSE(fixture.process.pause_pending());
      CHECK(fixture.process.interruption().ends_with("the cat jumped on it"));
      resumed ? fixture.process.resume() : fixture.process.cancel();
      fixture.run_out();
      CHECK(fixture.ends == std::vector{resumed ? PrintOutcome::Done : PrintOutcome::Canceled});
      if (!resumed) continue;
      REQUIRE(fixture.layers.size() == 3);
      for (const LayerRecord& layer : fixture.layers)
        CHECK(layer.exposure_most == layer.exposure_asked);
    }
  }
}

TEST_CASE("An interrupted exposure of the last layer is completed too") {
  for (const S state : {S::Exposing, S::Darkening, S::Lifting}) {
    CAPTURE(name_of(state));
    LayeredPrintFixture fixture;
    fixture.start(1);
    REQUIRE(fixture.run_to(state));
    fixture.process.interrupt("the lid was opened");
    fixture.run_out();
    CHECK(fixture.process.layered_state() == S::Paused);
    fixture.process.resume();
    fixture.run_out();
    CHECK(fixture.ends == std::vector{PrintOutcome::Done});
    REQUIRE(fixture.layers.size() == 1);
    CHECK(fixture.layers[0].exposure_most == fixture.layers[0].exposure_asked);
  }
}

TEST_CASE("An interruption at the instant at which an exposure ends leaves no remaining exposure") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  REQUIRE(fixture.run_to(S::Igniting));
  // This timer was requested before the exposure's timer, so it fires first.
  const auto opening = fixture.clock.call_after(20ms + 1s, [&] { fixture.machine.open_lid(); });
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 1);
  fixture.process.resume();
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 2);
  CHECK(fixture.layers[0].exposure_most == 1s);
  CHECK(fixture.layers[0].exposure_parts == 1);
}

TEST_CASE("A resume while the plate is still being lifted after an interruption does not skip the layer") {
  LayeredPrintFixture fixture;
  fixture.start(2);
  REQUIRE(fixture.run_to(S::Exposing));
  fixture.machine.open_lid();
  CHECK(fixture.process.layered_state() == S::Interrupting);
  REQUIRE(fixture.run_to(S::Lifting));
  CHECK(fixture.process.pause_pending());
  fixture.process.resume();
  fixture.run_out();
  CHECK(std::count(fixture.states.begin(), fixture.states.end(), S::Paused) == 0);
  REQUIRE(fixture.layers.size() == 2);
  CHECK(fixture.layers[0].exposure_most == 1s);
}

TEST_CASE("A cause that interrupts a print twice is reported once, and two causes are both reported") {
  LayeredPrintFixture fixture;
  fixture.start();
  REQUIRE(fixture.run_to(S::Settling));
  fixture.process.interrupt("the lid was opened");
  fixture.process.interrupt("the lid was opened");
  fixture.process.interrupt("HDMI-A-1 was unplugged");
  CHECK(fixture.process.interruption() == "the lid was opened; HDMI-A-1 was unplugged");
  CHECK(fixture.interruptions.size() == 2);
}

TEST_CASE("An interruption while the plate's position is unknown ends the print with the light off") {
  LayeredPrintFixture fixture;
  fixture.start();
  REQUIRE(fixture.run_to(S::Lowering));
  fixture.machine.z_axis().abort();
  fixture.process.interrupt("the lid was opened");
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
  CHECK_FALSE(fixture.light_at_end);
}

TEST_CASE("A pressed emergency stop ends the print at once and is reported as the reason") {
  for (const S state : kActiveStates) {
    CAPTURE(name_of(state));
    LayeredPrintFixture fixture;
    bring_to(fixture, state);
    fixture.machine.press_emergency_stop();
    CHECK_FALSE(fixture.machine.light_is_on());
    CHECK_FALSE(fixture.machine.z_axis().moving());
    CHECK(fixture.process.layered_state() == S::Ending);
    fixture.run_out();
    if (state == S::Ending) continue;
    CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
    CHECK(fixture.reason == "the emergency stop was pressed");
  }
}

TEST_CASE("A projector that stops answering ends the print with the light off") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.projector.silent_after_commands = 2;  // power on and the first light on
  LayeredPrintFixture fixture(config);
  fixture.start();
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
  CHECK(fixture.reason == "timed out after 30 s waiting for the projector to confirm that its light is off");
  REQUIRE(fixture.layers.size() == 2);
  CHECK(fixture.layers[0].dark_confirmed);
  CHECK_FALSE(fixture.layers[1].dark_confirmed);
  CHECK(fixture.layers[1].exposure_least == Duration{0});
  CHECK(fixture.layers[1].exposure_most > 30s);
  CHECK_FALSE(fixture.light_at_end);
}

namespace {

// An axis that homes and then never answers again.
class DeafAxis final : public testing::PlainAxis {
 public:
  explicit DeafAxis(Clock& clock) : clock_(clock) {}
  void home(std::function<void(HomingResult)> done) override {
    homing_ = clock_.call_after(1s, [done = std::move(done)] { done(HomingResult::Homed); });
  }
  void move_to(Nanometers, MillimetersPerSecond, std::function<void(MoveResult)>) override {}
  void stop() override {}
  void abort() noexcept override { aborted = true; }
  [[nodiscard]] bool moving() const override { return !aborted; }
  [[nodiscard]] std::optional<Nanometers> height() const override { return Nanometers{0}; }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint) const override { return height(); }
  [[nodiscard]] Nanometers travel() const override { return Nanometers{160'000'000}; }
  [[nodiscard]] Duration move_duration(Nanometers, MillimetersPerSecond) const override { return 10s; }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override { return {}; }
  [[nodiscard]] LateSteps late_steps() const override { return {}; }

  bool aborted = false;

 private:
  Clock& clock_;
  std::unique_ptr<Timer> homing_;
};

class DeafMachine final : public Machine {
 public:
  explicit DeafMachine(Clock& clock) : axis(clock), rest_(clock, testing::small_printer()) {}
  [[nodiscard]] ZAxis& z_axis() override { return axis; }
  [[nodiscard]] MaskDisplay& display() override { return rest_.display(); }
  [[nodiscard]] Projector& projector() override { return rest_.projector(); }
  void on_event(std::function<void(const MachineEvent&)>) override {}
  [[nodiscard]] std::string why_not_ready() const override { return ""; }
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  DeafAxis axis;

 private:
  SimulatedPrinter rest_;
};

// A machine whose projector was lost, after which another was found.
class ChangedMachine final : public Machine {
 public:
  explicit ChangedMachine(Clock& clock)
      : before(clock, testing::small_printer()), after(clock, testing::small_printer()) {}
  [[nodiscard]] ZAxis& z_axis() override { return before.z_axis(); }
  [[nodiscard]] MaskDisplay& display() override { return before.display(); }
  [[nodiscard]] Projector& projector() override { return (changed ? after : before).projector(); }
  void on_event(std::function<void(const MachineEvent&)>) override {}
  [[nodiscard]] std::string why_not_ready() const override { return ""; }
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  SimulatedPrinter before, after;
  bool changed = false;
};

}  // namespace

TEST_CASE("A projector found in place of a lost one does not answer for the lost projector's light") {
  LayeredPrintFixture observer;
  VirtualClock clock;
  ChangedMachine machine(clock);
  // The other projector has a light of its own: ten seconds.
  Projector& other = machine.after.projector();
  other.power_on([](ProjectorReply) {});
  while (clock.run_next()) {
  }
  other.light_on(10s, {.sent = [](TimePoint) {}, .done = [](ProjectorReply) {}});
  const auto off = clock.call_after(10s, [&other] { other.light_off(); });
  while (clock.run_next()) {
  }
  LayeredPrint process(machine, clock, observer);
  process.start(testing::box_plan(1));
  while (process.layered_state() != S::Exposing)
    REQUIRE(clock.run_next());
  REQUIRE(other.last_light());
  process.fail("the serial port was lost");
  machine.changed = true;
  SECTION("when something happens before the print is over") {
    process.interrupt("the emergency stop was touched");
  }
  SECTION("when nothing more happens") {}
  while (clock.run_next()) {
  }
  REQUIRE(observer.layers.size() == 1);
  CHECK(observer.layers[0].exposure_least < 1s);
  CHECK(observer.layers[0].exposure_most < 1s);
}

TEST_CASE(
    "A move that never ends fails the print after its expected time, a tenth and 15 s, and is aborted") {
  LayeredPrintFixture observer;
  VirtualClock clock;
  DeafMachine machine(clock);
  LayeredPrint process(machine, clock, observer);
  machine.axis.aborted = false;
  process.start(testing::box_plan(1));
  while (clock.run_next()) {
  }
  CHECK(observer.ends == std::vector{PrintOutcome::Failed});
  CHECK(observer.reason == "timed out after 26 s waiting for a move to end");
  CHECK(machine.axis.aborted);
}

TEST_CASE("A cancelled move that never stops fails the print instead of blocking it forever") {
  LayeredPrintFixture observer;
  VirtualClock clock;
  DeafMachine machine(clock);
  LayeredPrint process(machine, clock, observer);
  process.start(testing::box_plan(1));
  while (process.layered_state() != S::Lowering)
    REQUIRE(clock.run_next());
  machine.axis.aborted = false;
  process.cancel();
  CHECK(process.layered_state() == S::Halting);
  while (clock.run_next()) {
  }
  CHECK(observer.reason == "timed out after 15 s waiting for the axis to stop");
  CHECK(machine.axis.aborted);
}

TEST_CASE("A mask that cannot be shown ends the print with the reason, with the light off") {
  const TemporaryFolder folder;
  SimulatedPrinterConfig config = testing::small_printer();
  config.display.masks = folder.path() / "masks";
  LayeredPrintFixture fixture(config);
  const auto masks = fixture.machine.begin_job("box");
  REQUIRE(masks);
  fixture.start();
  REQUIRE(fixture.run_to(S::Resting));
  std::filesystem::remove_all(*masks);
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Failed});
  CHECK(fixture.reason.find("cannot write") != std::string::npos);
  CHECK_FALSE(fixture.machine.light_is_on());
  CHECK(fixture.machine.screen_is_black());
}

TEST_CASE("The process leaves the light off when it is destroyed in the middle of an exposure") {
  VirtualClock clock;
  SimulatedPrinter machine(clock, testing::small_printer());
  {
    LayeredPrintFixture unused;  // only an observer
    LayeredPrint process(machine, clock, unused);
    process.start(testing::box_plan(1));
    while (!machine.light_is_on())
      REQUIRE(clock.run_next());
  }
  while (clock.run_next()) {
  }  // pending callbacks must not reach the destroyed process
  CHECK_FALSE(machine.light_is_on());
  CHECK(machine.screen_is_black());
}

TEST_CASE("The time left is the actual duration of the print, with warm-up, homing and parking") {
  const auto plan_of = GENERATE(testing::box_plan, staged_plan, slow_plan, pressing_plan);
  LayeredPrintFixture fixture;
  PrintPlan plan = plan_of(3);
  plan.warm_up = 5s;  // as configured for the simulated projector
  fixture.process.start(std::move(plan));
  const Duration expected = fixture.process.time_left();
  PrinterConfig printer;
  printer.travel = fixture.machine.z_axis().travel();
  printer.simulated = testing::small_printer();
  PrintPlan forecast = plan_of(3);
  forecast.warm_up = 5s;
  const PrintForecast by_cause = forecast_of(forecast, printer);
  CHECK(by_cause.time.total() == expected);
  CHECK(by_cause.typical.time.total() <= by_cause.longest.time.total());
  CHECK(by_cause.time[TimeCause::WarmingUp] == 5s);
  CHECK(by_cause.time[TimeCause::Switching] == Duration{});
  const TimePoint start = fixture.clock.now();
  REQUIRE(fixture.run_to(S::Ending));
  const Duration real = fixture.clock.now() - start;
  // The plate was at 40 mm, an unknown height; the estimate assumes the parking height.
  const ZAxis& axis = fixture.machine.z_axis();
  const Duration sooner = axis.move_duration(axis.travel(), MillimetersPerSecond{5}) -
                          axis.move_duration(Nanometers{40'000'000}, MillimetersPerSecond{5});
  // The estimate ignores two frames and two replies for each layer.
  CHECK(std::chrono::abs(real - (expected - sooner)) < 3 * (2 * 17ms + 2 * 20ms) + 100ms);
}

TEST_CASE("The time left counts down in every state of known duration") {
  LayeredPrintFixture fixture;
  PrintPlan plan = testing::box_plan(1);
  plan.warm_up = 5s;
  fixture.process.start(std::move(plan));
  const auto state = GENERATE(S::WarmingUp, S::Homing, S::Lowering, S::Settling, S::Exposing, S::Resting,
                              S::Lifting, S::Parking);
  REQUIRE(fixture.run_to(state));
  INFO(name_of(state));
  const Duration total = fixture.process.time_left();
  const Duration in_state = fixture.process.state_left().value();
  REQUIRE(in_state > 50ms);
  bool looked = false;
  const auto look = fixture.clock.call_after(50ms, [&] {
    looked = true;
    CHECK(fixture.process.time_left() == total - 50ms);
    CHECK(fixture.process.state_left() == in_state - 50ms);
  });
  while (!looked)
    REQUIRE(fixture.clock.run_next());
}

TEST_CASE("The time left stands still while the print waits for the user") {
  LayeredPrintFixture fixture;
  bring_to(fixture, S::Paused);
  CHECK_FALSE(fixture.process.state_left());
  const Duration left = fixture.process.time_left();
  bool looked = false;
  const auto look = fixture.clock.call_after(1min, [&looked] { looked = true; });
  while (!looked)
    REQUIRE(fixture.clock.run_next());
  CHECK(fixture.process.time_left() == left);
}

TEST_CASE("The time left of a cancelled print is the time for parking") {
  LayeredPrintFixture fixture;
  fixture.start(100);
  REQUIRE(fixture.run_to(S::Lifting));
  fixture.process.cancel();
  const ZAxis& axis = fixture.machine.z_axis();
  const Duration whole = axis.move_duration(axis.travel(), MillimetersPerSecond{5});
  CHECK(fixture.process.time_left() <= whole + 1s);
  CHECK(fixture.process.time_left() > whole / 2);
}

TEST_CASE("A second print follows the first on the same machine") {
  LayeredPrintFixture fixture;
  fixture.start(1);
  fixture.run_out();
  fixture.start(2);
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done, PrintOutcome::Done});
  CHECK(fixture.layers.size() == 3);
}

TEST_CASE(
    "A split exposure shows its second picture while the light is on, at the refresh nearest to its time") {
  LayeredPrintFixture fixture;
  fixture.process.start(split_plan(2));
  REQUIRE(fixture.run_to(S::Exposing));
  const std::int64_t all = fixture.process.shown().mask->lit_pixels();
  const TimePoint lit_at = fixture.clock.now();
  while (fixture.machine.masks_shown() < 2)
    REQUIRE(fixture.clock.run_next());
  CHECK(fixture.process.layered_state() == S::Exposing);
  CHECK(fixture.process.shown().mask->lit_pixels() * 2 == all);
  CHECK(std::ranges::count(fixture.states, S::Exposing) == 1);  // the observer is not told of pictures
  const Duration due = std::chrono::seconds{1} * 64 / 255, half = fixture.machine.display().frame() / 2;
  CHECK(fixture.clock.now() - lit_at >= due - half - 25ms);
  fixture.run_out();
  CHECK(fixture.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(fixture.lit_wrongly);
  REQUIRE(fixture.layers.size() == 2);
  for (const LayerRecord& layer : fixture.layers) {
    CHECK(layer.pictures == 2);
    CHECK(layer.light_error == 0);
    CHECK(layer.late_picture <= half);
    CHECK(layer.exposure_parts == 1);
  }
}

TEST_CASE(
    "A split exposure that is interrupted turns dark, and its rest begins with the picture that was due") {
  LayeredPrintFixture fixture;
  fixture.process.start(split_plan(1));
  while (fixture.machine.masks_shown() < 2)
    REQUIRE(fixture.clock.run_next());
  REQUIRE(fixture.process.layered_state() == S::Exposing);
  const std::int64_t part = fixture.process.shown().mask->lit_pixels();
  const TimePoint soon = fixture.clock.now() + 100ms;
  const auto timer = fixture.clock.call_at(soon, [] {});
  while (fixture.clock.now() < soon)
    REQUIRE(fixture.clock.run_next());
  fixture.process.interrupt("the lid was opened");
  CHECK_FALSE(fixture.machine.light_is_on());
  CHECK(fixture.machine.screen_is_black());
  REQUIRE(fixture.run_to(S::Paused));
  fixture.process.resume();
  REQUIRE(fixture.run_to_light());
  CHECK(fixture.process.shown().mask->lit_pixels() == part);
  fixture.run_out();
  CHECK(fixture.machine.masks_shown() == 3);
  REQUIRE(fixture.layers.size() == 1);
  CHECK(fixture.layers[0].exposure_parts == 2);
  CHECK(fixture.layers[0].pictures == 2);
  CHECK(fixture.layers[0].complete);
  CHECK_FALSE(fixture.lit_wrongly);
}

TEST_CASE("A display that is lost in a split exposure interrupts it, with the late picture in the record") {
  SimulatedPrinterConfig config = testing::small_printer();
  config.display.lost_after_frames = 1;
  LayeredPrintFixture fixture(config);
  fixture.process.start(split_plan(1));
  fixture.run_out();
  CHECK(fixture.process.layered_state() == S::Paused);
  CHECK(fixture.interruptions.size() == 1);
  CHECK_FALSE(fixture.machine.light_is_on());
  fixture.process.cancel();
  fixture.run_out();
  REQUIRE(fixture.layers.size() == 1);
  CHECK_FALSE(fixture.layers[0].complete);
  CHECK(fixture.layers[0].exposure_most < 300ms);
  CHECK_FALSE(fixture.lit_wrongly);
}
