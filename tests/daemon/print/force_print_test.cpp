// Tests of prints on a simulated printer with a force line: peels, parts that come off, resistance.

#include "daemon/print/layered_print.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"

namespace {

using S = LayeredState;

Nanometers height_mm(double mm) {
  return Nanometers{std::llround(mm * 1e6)};
}

// Returns a printer on which the box of 6 mm² lets go at 0.59 mm: its peel of 2.96 N stretches the film,
// whose threshold of 1 N is reached at 0.2 mm.
SimulatedPrinterConfig force_printer() {
  SimulatedPrinterConfig config = testing::small_printer();
  config.axis.force = SimulatedForceConfig{.pixel_mm = 0.1, .peel_kpa = 1000};
  return config;
}

// Something lies on the film when the third layer's plate comes down.
SimulatedPrinterConfig obstructed_printer() {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->obstruction = height_mm(3);
  config.axis.force->obstruction_after_lifts = 2;
  return config;
}
constexpr double kLetsGoMm = 0.59, kSampledMm = 0.03;  // 10 ms at 2 mm/s, and rounding

PrintPlan force_plan(int layers) {
  PrintPlan plan = testing::box_plan(layers);
  plan.motion.lift = height_mm(2);
  plan.motion.second_lift = height_mm(3);
  plan.motion.second_lift_speed = MillimetersPerSecond{4};
  plan.force =
      ForcePolicy{.contact_from = height_mm(2), .least_peel_area_mm2 = 5, .pauses_without_peel = true};
  return plan;
}

class ForcePrintFixture final : public PrintObserver {
 public:
  explicit ForcePrintFixture(const SimulatedPrinterConfig& config = force_printer())
      : machine(clock, config), process(machine, clock, *this) {}

  // Runs until `done`; false if the print ends before.
  bool run_until(const std::function<bool()>& done) {
    while (!done()) {
      if (!clock.run_next()) return false;
      const EnumSet<S> lit{S::Igniting, S::Exposing};
      lit_wrongly = lit_wrongly || (machine.light_is_on() && !lit.contains(process.layered_state()));
    }
    return true;
  }
  bool run_to(LayeredState state) {
    return run_until([&] { return process.layered_state() == state; });
  }
  void run_out() {
    CHECK_FALSE(run_until([] { return false; }));
    CHECK_FALSE(lit_wrongly);
  }

  void light_due() override {}
  void state_changed(const PrintState& state) override {
    if (state.name == "awaiting dark" && machine.z_axis().height())
      lifted_to.push_back(in_mm(*machine.z_axis().height()));
  }
  void layer_done(const LayerRecord& layer) override { layers.push_back(layer); }
  void layer_peeled(std::int32_t layer, const PeelRecord& peel) override { peels.emplace_back(layer, peel); }
  void warned(const std::string& what) override { warnings.push_back(what); }
  void interrupted(const std::string& what) override { interruptions.push_back(what); }
  void light_gone() override {}
  void print_ended(PrintOutcome ended, const std::string& why, PrintPlan) override {
    outcome = ended;
    reason = why;
  }

  VirtualClock clock;
  SimulatedPrinter machine;
  std::vector<LayerRecord> layers;
  std::vector<std::pair<std::int32_t, PeelRecord>> peels;
  std::vector<std::string> warnings, interruptions;
  std::vector<double> lifted_to;
  std::optional<PrintOutcome> outcome;
  std::string reason;
  bool lit_wrongly = false;
  LayeredPrint process;
};

// Returns the time of a print, and the heights to which its lifts went.
std::pair<Duration, std::vector<double>> printed(bool force) {
  SimulatedPrinterConfig config = force_printer();
  if (!force) config.axis.force.reset();
  ForcePrintFixture fixture(config);
  fixture.process.start(force_plan(5));
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  return {fixture.clock.now().time_since_epoch(), fixture.lifted_to};
}

}  // namespace

TEST_CASE("The slow stage of a lift ends when the layer lets go, and the lift is as high as before") {
  ForcePrintFixture fixture;
  fixture.process.start(force_plan(5));
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  CHECK(fixture.interruptions.empty());
  REQUIRE(fixture.peels.size() == 5);
  Duration saved{};
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& [layer, peel] = fixture.peels[i];
    CHECK(layer == static_cast<std::int32_t>(i));
    CHECK(peel.felt);
    CHECK_FALSE(peel.missed);
    REQUIRE(peel.distance);
    CHECK(in_mm(*peel.distance) == Approx(kLetsGoMm).margin(kSampledMm));
    // 1.4 mm at 4 instead of 2 mm/s, less 0.16 s to start again
    CHECK(peel.saved > 100ms);
    CHECK(peel.saved < 400ms);
    saved += peel.saved;
  }
  const auto [with, high] = printed(true);
  const auto [without, as_high] = printed(false);
  CHECK(high == as_high);
  // Each light begins with a refresh of the screen.
  CHECK(std::chrono::abs(without - with - saved) < 5 * 17ms);
}

TEST_CASE("Resistance on the way down pauses the print in the dark, and it goes on when nothing is there") {
  ForcePrintFixture fixture(obstructed_printer());
  fixture.process.start(force_plan(4));
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 2);
  REQUIRE(fixture.interruptions.size() == 1);
  CHECK(
      fixture.interruptions[0] ==
      "the plate met resistance at 3.150 mm on its way down to 0.150 mm, where force is expected only below "
      "2.150 mm: remove what lies on the film or came off the plate, or check the force line, before it "
      "goes on");
  CHECK(in_mm(fixture.machine.z_axis().height().value()) == Approx(3.15 + 5 + 30));
  CHECK_FALSE(fixture.machine.light_is_on());
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  REQUIRE(fixture.layers.size() == 4);
  for (const LayerRecord& layer : fixture.layers)
    CHECK(layer.exposure_parts == 1);
}

TEST_CASE("Resistance near the film is the resin's") {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->obstruction = height_mm(1.9);
  ForcePrintFixture fixture(config);
  fixture.process.start(force_plan(2));
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  CHECK(fixture.interruptions.empty());
}

TEST_CASE("Resistance ends the print where the printer's file says so, and leaves the plate where it is") {
  ForcePrintFixture fixture(obstructed_printer());
  PrintPlan plan = force_plan(4);
  plan.force->resistance_fails = true;
  fixture.process.start(std::move(plan));
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Failed);
  CHECK(fixture.reason.starts_with("the plate met resistance at 3.150 mm on its way down to 0.150 mm, "));
  CHECK(in_mm(fixture.machine.z_axis().height().value()) == Approx(3.15));
}

TEST_CASE("A part that comes off is reported at the layer that is not felt, and pauses the print") {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->part_lost_after_lifts = 4;
  ForcePrintFixture fixture(config);
  fixture.process.start(force_plan(9));
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 5);
  REQUIRE(fixture.interruptions.size() == 1);
  CHECK(fixture.interruptions[0].starts_with("no force was felt while layer 5 of 6 mm² was peeled off"));
  CHECK(fixture.peels.back().second.missed);
  CHECK_FALSE(fixture.peels.back().second.felt);
  fixture.process.resume();  // whoever goes on is not asked for every layer
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  CHECK(fixture.interruptions.size() == 1);

  ForcePrintFixture other(config);
  PrintPlan plan = force_plan(9);
  plan.force->pauses_without_peel = false;
  other.process.start(std::move(plan));
  other.run_out();
  CHECK(other.outcome == PrintOutcome::Done);
  CHECK(other.interruptions.empty());
  REQUIRE(other.warnings.size() == 1);
  CHECK(other.warnings[0] == fixture.interruptions[0]);
}

TEST_CASE("A force line that is never active is reported after five layers") {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->line = SimulatedForceConfig::Line::StuckInactive;
  ForcePrintFixture fixture(config);
  fixture.process.start(force_plan(9));
  REQUIRE(fixture.run_to(S::Paused));
  CHECK(fixture.layers.size() == 5);
  CHECK(fixture.interruptions.at(0).starts_with("no force was felt in the first 5 lifts of at least 5 mm²"));
  fixture.process.resume();
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);

  // The box is too small to be felt, or the layers have no light.
  for (const bool dry : {false, true}) {
    ForcePrintFixture other(config);
    PrintPlan plan = force_plan(9);
    plan.dry = dry;
    if (!dry) plan.force->least_peel_area_mm2 = 7;
    other.process.start(std::move(plan));
    other.run_out();
    CHECK(other.outcome == PrintOutcome::Done);
    CHECK(other.interruptions.empty());
  }
}

TEST_CASE("A force line that is always active moves no plate down") {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->line = SimulatedForceConfig::Line::StuckActive;
  ForcePrintFixture fixture(config);
  CHECK(
      force_at_rest(fixture.machine).starts_with("the force line (simulated) is active although the plate"));
  fixture.process.start(force_plan(3));
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Failed);
  CHECK(fixture.reason == "homing failed: resistance stopped the plate on its way down");
}

TEST_CASE("A lift whose slow stage has just ended can be cancelled and interrupted") {
  for (const bool cancels : {true, false}) {
    for (int steps = 0; steps < 40; ++steps) {
      ForcePrintFixture fixture;
      fixture.process.start(force_plan(3));
      REQUIRE(fixture.run_until([&] { return fixture.layers.size() == 1; }));
      REQUIRE(fixture.run_to(S::Lifting));
      fixture.run_until(
          [&, end = fixture.clock.now() + 300ms + steps * 4ms] { return fixture.clock.now() >= end; });
      cancels ? fixture.process.cancel() : fixture.process.interrupt("the lid was opened");
      if (!cancels) {
        REQUIRE(fixture.run_to(S::Paused));
        fixture.process.resume();
      }
      fixture.run_out();
      CHECK(fixture.outcome == (cancels ? PrintOutcome::Canceled : PrintOutcome::Done));
      CHECK(fixture.machine.z_axis().height().has_value());
    }
  }
}

TEST_CASE("A move by hand that meets resistance says so, and its position is still known") {
  SimulatedPrinterConfig config = force_printer();
  config.axis.force->obstruction = height_mm(3);
  ForcePrintFixture fixture(config);
  std::optional<HomingResult> homed;
  fixture.machine.z_axis().home([&](HomingResult result) { homed = result; });
  fixture.run_until([&] { return homed.has_value(); });
  std::optional<MoveResult> moved;
  fixture.machine.z_axis().move_to(height_mm(10), MillimetersPerSecond{5}, [&](MoveResult r) { moved = r; });
  fixture.run_until([&] { return moved.has_value(); });
  moved.reset();
  fixture.machine.z_axis().move_to(height_mm(1), MillimetersPerSecond{5}, [&](MoveResult r) { moved = r; });
  fixture.run_until([&] { return moved.has_value(); });
  CHECK(moved == MoveResult::Resistance);
  CHECK(fixture.machine.z_axis().height() == height_mm(3));
  CHECK(fixture.machine.z_axis().force() == true);
}
