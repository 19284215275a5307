// Tests of a print on a GPIO axis with a GPIO light line, an emergency stop and a lid, whose contacts move
// during the print.

#include "daemon/print/layered_print.hpp"
#include "hw/gpio/gpio_light_line.hpp"
#include "hw/projector_with_light_line.hpp"
#include "hw/simulated_printer.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/box_print.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/models/dice.hpp"

namespace {

using S = LayeredState;

constexpr int kLayers = 3;
constexpr Duration kExposure = 1s;

GpioAxisConfig axis_config() {
  GpioAxisConfig config;
  config.travel = Nanometers{40'000'000};
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}};
  config.lid = GpioInputConfig{{"gpiochip0", "6", false}};
  config.power_fail = GpioInputConfig{{"gpiochip0", "13", false}};
  config.force = ForceConfig{.input = {{"gpiochip0", "14", false}}, .contact_from = Nanometers{2'000'000}};
  return config;
}

PrintPlan print_plan() {
  PrintPlan plan = testing::box_plan(kLayers);
  plan.exposure = [](std::int32_t, Nanometers) { return kExposure; };
  plan.motion.lift = Nanometers{4'000'000};
  return plan;
}

class PrintSafetyFixture final : public Machine, public PrintObserver {
 public:
  PrintSafetyFixture() {
    plant.build();
    auto output = std::make_unique<PlantOutput>();
    line = output.get();
    light.emplace(std::move(output), "line 24 of gpiochip0", plant.clock);
    lamp.emplace(*light, plant.clock, Duration{1s});
    plant.axis->set_light_cutoff(&*light);
    plant.axis->on_event([this](const MachineEvent& event) {
      if (event.kind == MachineEvent::Kind::Interlock) process->interrupt(event.what);
      if (event.kind == MachineEvent::Kind::Fault) process->fail(event.what);
    });
    process.emplace(*this, plant.clock, *this);
  }
  ~PrintSafetyFixture() override {
    process.reset();
    plant.axis->set_light_cutoff(nullptr);
  }

  [[nodiscard]] ZAxis& z_axis() override { return *plant.axis; }
  [[nodiscard]] MaskDisplay& display() override { return screen.display(); }
  [[nodiscard]] Projector& projector() override { return *lamp; }
  void on_event(std::function<void(const MachineEvent&)>) override {}
  [[nodiscard]] std::string why_not_ready() const override {
    std::string all;
    for (const std::string& one : plant.axis->why_not_ready())
      all += one;
    return all;
  }
  std::optional<std::filesystem::path> begin_job(std::string_view) override { return std::nullopt; }

  void light_due() override {}
  void state_changed(const PrintState&) override {}
  void layer_done(const LayerRecord& layer) override { layers.push_back(layer); }
  void interrupted(const std::string& what) override { interruptions.push_back(what); }
  void light_gone() override {}
  void print_ended(PrintOutcome ended, const std::string& why, PrintPlan) override {
    outcome = ended;
    reason = why;
  }

  bool run_to(LayeredState state) {
    plant.run([&] { return process->layered_state() == state || outcome; });
    return process->layered_state() == state;
  }
  // Runs a print to the state; to its occurrence in the second layer if the state belongs to a layer.
  void bring_to(LayeredState state) {
    process->start(print_plan());
    if (state == S::WarmingUp || state == S::Homing || state == S::Parking) {
      REQUIRE(run_to(state));
    } else {
      plant.run([&] { return layers.size() == 1; });
      if (state == S::Raising || state == S::Paused) process->pause();
      REQUIRE(run_to(state));
    }
    plant.run_for(10us);  // so that the state has really begun
  }
  void press(AxisInput which, Duration lasting) {
    plant.press(which, true);
    release = plant.clock.call_after(lasting, [this, which] { plant.press(which, false); });
  }
  // Runs the print to its end; whenever it waits for the user, resumes it as soon as the machine is ready.
  void run_out() {
    while (!outcome) {
      plant.run([&] {
        return outcome || process->layered_state() == S::Paused || process->layered_state() == S::Held;
      });
      if (outcome) return;
      plant.run([&] { return why_not_ready().empty(); });
      process->resume();
    }
  }

  Plant plant{axis_config()};
  SimulatedPrinter screen{plant.clock, testing::small_printer()};
  PlantOutput* line = nullptr;
  std::optional<GpioLightLine> light;
  std::optional<LightLineProjector> lamp;
  std::optional<LayeredPrint> process;
  std::unique_ptr<Timer> release;
  std::vector<LayerRecord> layers;
  std::vector<std::string> interruptions;
  std::optional<PrintOutcome> outcome;
  std::string reason;
};

constexpr LayeredState kStates[] = {S::WarmingUp, S::Homing,   S::Lowering,  S::Settling,
                                    S::Showing,   S::Exposing, S::Darkening, S::Resting,
                                    S::Lifting,   S::Raising,  S::Paused,    S::Parking};

}  // namespace

TEST_CASE("A print can be finished after a spike on the line of any safety input in any state") {
  for (const AxisInput which : {AxisInput::EmergencyStop, AxisInput::Lid, AxisInput::PowerFail}) {
    for (const LayeredState state : kStates) {
      CAPTURE(name_of(state), static_cast<int>(which));
      PrintSafetyFixture fixture;
      fixture.bring_to(state);
      fixture.press(which, 1ms);
      fixture.plant.run_for(100us);  // the thread needs 60 us to wake up
      CHECK_FALSE(fixture.line->level);
      CHECK_FALSE(fixture.why_not_ready().empty());
      CHECK(fixture.interruptions.size() == 1);
      fixture.run_out();
      CHECK(fixture.outcome == PrintOutcome::Done);
      CHECK(fixture.reason.empty());
      REQUIRE(fixture.layers.size() == kLayers);
      for (const LayerRecord& layer : fixture.layers) {
        // The missing exposure is given later. The light is known to within 60 us, a wake-up of the thread.
        CHECK(layer.exposure_least >= kExposure - 1ms);
        CHECK(layer.exposure_most <= kExposure + 1ms);
      }
    }
  }
}

TEST_CASE("A supply that fails in any state interrupts the print dark, which is finished when it is back") {
  for (const LayeredState state : kStates) {
    CAPTURE(name_of(state));
    PrintSafetyFixture fixture;
    fixture.bring_to(state);
    fixture.press(AxisInput::PowerFail, 60s);
    fixture.plant.run_for(100us);
    CHECK_FALSE(fixture.line->level);
    fixture.plant.run_for(30s);
    CHECK_FALSE(fixture.line->level);
    CHECK(fixture.why_not_ready() == "the power is failing");
    CHECK(fixture.interruptions == std::vector<std::string>{"the power is failing (line 13 of gpiochip0)"});
    fixture.plant.run_for(31s);
    CHECK(fixture.why_not_ready().empty());
    fixture.run_out();
    CHECK(fixture.outcome == PrintOutcome::Done);
    REQUIRE(fixture.layers.size() == kLayers);
    for (const LayerRecord& layer : fixture.layers)
      CHECK(layer.exposure_least >= kExposure - 1ms);
  }
}

TEST_CASE("An emergency stop in any state ends the print dark, without a step after its debounce time") {
  for (const LayeredState state : kStates) {
    CAPTURE(name_of(state));
    PrintSafetyFixture fixture;
    fixture.bring_to(state);
    const TimePoint pressed = fixture.plant.clock.now();
    fixture.press(AxisInput::EmergencyStop, 1000s);
    fixture.plant.run_for(100us);
    CHECK_FALSE(fixture.line->level);
    fixture.plant.run_for(60s);
    CHECK(fixture.outcome == PrintOutcome::Failed);
    CHECK(fixture.reason == "the emergency stop is pressed (line 5 of gpiochip0)");
    CHECK_FALSE(fixture.line->level);
    if (!fixture.plant.pulses.empty()) CHECK(fixture.plant.pulses.back() - pressed <= 5ms + 60us);
  }
}

TEST_CASE("A light that is refused because the lid has just moved interrupts the print and is not a fault") {
  PrintSafetyFixture fixture;
  fixture.bring_to(S::Showing);
  fixture.press(AxisInput::Lid, 2s);
  // The mask is shown and the light requested before the process learns of the lid.
  fixture.plant.run_threads_for(100ms);
  CHECK_FALSE(fixture.line->level);
  REQUIRE(fixture.interruptions.size() == 2);
  CHECK(fixture.interruptions[0].find("stays off") != std::string::npos);
  CHECK(fixture.interruptions[1] == "the lid was opened (line 6 of gpiochip0)");
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
}

TEST_CASE("Several spikes pause the print each time, and it can still be finished") {
  PrintSafetyFixture fixture;
  fixture.bring_to(S::Exposing);
  for (int i = 0; i < 5; ++i) {
    fixture.press(i % 2 == 0 ? AxisInput::EmergencyStop : AxisInput::Lid, 1ms);
    REQUIRE(fixture.run_to(S::Paused));
    fixture.plant.run_for(100ms);
    REQUIRE(fixture.why_not_ready().empty());
    fixture.process->resume();
    REQUIRE(fixture.run_to(S::Exposing));
    fixture.plant.run_for(50ms);
  }
  fixture.run_out();
  CHECK(fixture.outcome == PrintOutcome::Done);
  CHECK(fixture.layers.size() == kLayers);
}

TEST_CASE(
    "Force at any instant of a print never shines, loses no step, and leaves a print that can be finished") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    models::Dice dice(seed, 0);
    PrintSafetyFixture fixture;
    fixture.plant.pull_in = 2'020;  // steps/s; the motor loses steps when it stops dead from above
    PrintPlan plan = print_plan();
    plan.motion.second_lift = Nanometers{2'000'000};
    plan.motion.second_lift_speed = MillimetersPerSecond{4};
    plan.force = ForcePolicy{.contact_from = Nanometers{2'000'000}, .least_peel_area_mm2 = 1e6};
    fixture.process->start(std::move(plan));
    std::vector<std::unique_ptr<Timer>> presses;
    for (auto left = dice.whole(1, 6); left > 0; --left) {
      const Duration at = dice.between(20s, 60s), lasting = dice.spread(1ms, 3s);
      for (const bool pressed : {true, false})
        presses.push_back(fixture.plant.clock.call_after(pressed ? at : at + lasting, [&fixture, pressed] {
          fixture.plant.press(AxisInput::Force, pressed);
        }));
    }
    const EnumSet<S> lit{S::Igniting, S::Exposing};
    bool lit_wrongly = false;
    for (int resumed = 0; !fixture.outcome && resumed < 1'000; ++resumed) {
      fixture.plant.run([&] {
        lit_wrongly = lit_wrongly || (fixture.line->level && !lit.contains(fixture.process->layered_state()));
        return fixture.outcome || fixture.process->layered_state() == S::Paused;
      });
      if (!fixture.outcome) fixture.process->resume();
    }
    CHECK_FALSE(lit_wrongly);
    CHECK(fixture.reason.empty());
    REQUIRE(fixture.outcome == PrintOutcome::Done);
    REQUIRE(fixture.plant.axis->height().has_value());
    const double off =
        in_mm(*fixture.plant.axis->height()) * 800 - static_cast<double>(fixture.plant.plate());
    CHECK(std::fabs(off) < 0.01);
    REQUIRE(fixture.layers.size() == kLayers);
    for (const LayerRecord& layer : fixture.layers) {
      CHECK(layer.exposure_least >= kExposure - 1ms);
      CHECK(layer.exposure_most <= kExposure + 1ms);
      CHECK(layer.exposure_parts == 1);
    }
  }
}
