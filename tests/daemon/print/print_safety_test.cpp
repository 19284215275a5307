// A print on an axis of lines and a light of a line, with an emergency stop and a lid: what becomes of it
// when their contacts move.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/print/print_process.hpp"
#include "hw/gpio/gpio_light_line.hpp"
#include "hw/projector_with_light_line.hpp"
#include "hw/simulated_printer.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::Plant;
using testing::PlantOutput;
using S = PrintState;

namespace {

constexpr DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};
constexpr Nanometers kLayer{50'000};
constexpr int kLayers = 3;
constexpr Duration kExposure = 1s;

GpioAxisConfig axis_config() {
  GpioAxisConfig config;
  config.travel = Nanometers{40'000'000};
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}};
  config.lid = GpioInputConfig{{"gpiochip0", "6", false}};
  return config;
}

SimulatedPrinterConfig display_config() {
  SimulatedPrinterConfig config;
  config.display.width = kDisplay.width;
  config.display.height = kDisplay.height;
  return config;
}

PrintPlan print_plan() {
  PrintPlan plan;
  plan.job = "box";
  HeightIndex box(models::box({0, 0, 0}, {3, 2, 0.15F}));
  plan.engine = std::make_unique<ContourEngine>(std::move(box), EngineSettings{.display = kDisplay},
                                                std::vector{PixelMap::true_scale(kDisplay, {1.5, 1})});
  plan.layers = PrintLayers(LayerStack{kLayer, kLayers});
  plan.expected_layers = plan.layers.all();
  plan.exposure = [](std::int32_t, Nanometers) { return kExposure; };
  plan.pixel_area_mm2 = 0.01;
  plan.lift = Nanometers{4'000'000};
  plan.lift_speed = MillimetersPerSecond{2};
  plan.retract_speed = plan.travel_speed = plan.homing_speed = MillimetersPerSecond{5};
  plan.settle = 700ms;
  plan.rest = 300ms;
  return plan;
}

class Bench final : public Machine, public PrintObserver {
 public:
  Bench() {
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
  ~Bench() override {
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

  void state_changed(PrintState) override {}
  void layer_done(const LayerRecord& layer) override { layers.push_back(layer); }
  void interrupted(const std::string& what) override { interruptions.push_back(what); }
  void light_gone() override {}
  void print_ended(PrintOutcome ended, const std::string& why, PrintPlan) override {
    outcome = ended;
    reason = why;
  }

  bool run_to(PrintState state) {
    plant.run([&] { return process->state() == state || outcome; });
    return process->state() == state;
  }
  // On the second layer, where the state is one of a layer's.
  void bring_to(PrintState state) {
    process->start(print_plan());
    if (state == S::WarmingUp || state == S::Homing || state == S::Parking) {
      REQUIRE(run_to(state));
    } else {
      plant.run([&] { return layers.size() == 1; });
      if (state == S::Raising || state == S::Paused) process->pause();
      REQUIRE(run_to(state));
    }
    plant.run_for(10us);  // well in it, where it lasts
  }
  void press(AxisInput which, Duration lasting) {
    plant.press(which, true);
    release = plant.clock.call_after(lasting, [this, which] { plant.press(which, false); });
  }
  // Until it waits for its owner, or is over; the owner resumes as soon as nothing is in the way.
  void run_out() {
    while (!outcome) {
      plant.run([&] { return outcome || process->state() == S::Paused || process->state() == S::Held; });
      if (outcome) return;
      plant.run([&] { return why_not_ready().empty(); });
      process->resume();
    }
  }

  Plant plant{axis_config()};
  SimulatedPrinter screen{plant.clock, display_config()};
  PlantOutput* line = nullptr;
  std::optional<GpioLightLine> light;
  std::optional<LightLineProjector> lamp;
  std::optional<PrintProcess> process;
  std::unique_ptr<Timer> release;
  std::vector<LayerRecord> layers;
  std::vector<std::string> interruptions;
  std::optional<PrintOutcome> outcome;
  std::string reason;
};

constexpr PrintState kStates[] = {S::WarmingUp, S::Homing,  S::Lowering, S::Settling, S::Showing, S::Exposing,
                                  S::Darkening, S::Resting, S::Lifting,  S::Raising,  S::Paused,  S::Parking};

}  // namespace

TEST_CASE(
    "A spike on the emergency stop's or the lid's line in any state leaves a print that can be finished") {
  for (const AxisInput which : {AxisInput::EmergencyStop, AxisInput::Lid}) {
    for (const PrintState state : kStates) {
      CAPTURE(name_of(state), which == AxisInput::Lid);
      Bench bench;
      bench.bring_to(state);
      bench.press(which, 1ms);
      bench.plant.run_for(100us);  // 60 us until the thread has woken
      CHECK_FALSE(bench.line->level);
      CHECK_FALSE(bench.why_not_ready().empty());
      CHECK(bench.interruptions.size() == 1);
      bench.run_out();
      CHECK(bench.outcome == PrintOutcome::Done);
      CHECK(bench.reason.empty());
      REQUIRE(bench.layers.size() == kLayers);
      for (const LayerRecord& layer : bench.layers) {
        // What the cut took off is given later; the light is known to a wake-up of the thread, 60 us.
        CHECK(layer.exposure_least >= kExposure - 1ms);
        CHECK(layer.exposure_most <= kExposure + 1ms);
      }
    }
  }
}

TEST_CASE("An emergency stop in any state ends the print dark, without a step once it has lasted") {
  for (const PrintState state : kStates) {
    CAPTURE(name_of(state));
    Bench bench;
    bench.bring_to(state);
    const TimePoint pressed = bench.plant.clock.now();
    bench.press(AxisInput::EmergencyStop, 1000s);
    bench.plant.run_for(100us);
    CHECK_FALSE(bench.line->level);
    bench.plant.run_for(60s);
    CHECK(bench.outcome == PrintOutcome::Failed);
    CHECK(bench.reason == "the emergency stop is pressed (line 5 of gpiochip0)");
    CHECK_FALSE(bench.line->level);
    if (!bench.plant.pulses.empty()) CHECK(bench.plant.pulses.back() - pressed <= 5ms + 60us);
  }
}

TEST_CASE("A light that is refused because the lid has just moved interrupts the print, and is no fault") {
  Bench bench;
  bench.bring_to(S::Showing);
  bench.press(AxisInput::Lid, 2s);
  bench.plant.run_threads_for(100ms);  // the mask is shown, the light asked for, and the lid not heard of yet
  CHECK_FALSE(bench.line->level);
  REQUIRE(bench.interruptions.size() == 2);
  CHECK(bench.interruptions[0].find("stays off") != std::string::npos);
  CHECK(bench.interruptions[1] == "the lid was opened (line 6 of gpiochip0)");
  bench.run_out();
  CHECK(bench.outcome == PrintOutcome::Done);
}

TEST_CASE("Several spikes in one print pause it each time, and it is finished all the same") {
  Bench bench;
  bench.bring_to(S::Exposing);
  for (int i = 0; i < 5; ++i) {
    bench.press(i % 2 == 0 ? AxisInput::EmergencyStop : AxisInput::Lid, 1ms);
    REQUIRE(bench.run_to(S::Paused));
    bench.plant.run_for(100ms);
    REQUIRE(bench.why_not_ready().empty());
    bench.process->resume();
    REQUIRE(bench.run_to(S::Exposing));
    bench.plant.run_for(50ms);
  }
  bench.run_out();
  CHECK(bench.outcome == PrintOutcome::Done);
  CHECK(bench.layers.size() == kLayers);
}
