#include "daemon/print/print_process.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/models/models.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using contourd::testing::TemporaryFolder;

namespace {

constexpr DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};
constexpr Nanometers kLayer{50'000};

// A printer with a print in it, driven call by call.
class Bench final : public PrintObserver {
 public:
  explicit Bench(const SimulatedPrinterConfig& config = small_printer())
      : machine(clock, config), process(machine, clock, *this) {
    machine.on_event([this](const MachineEvent& event) {
      if (event.kind == MachineEvent::Kind::Interlock) process.interrupt(event.what);
      if (event.kind == MachineEvent::Kind::Fault) process.fail(event.what);
    });
  }

  static SimulatedPrinterConfig small_printer() {
    SimulatedPrinterConfig config;
    config.display.width = kDisplay.width;
    config.display.height = kDisplay.height;
    return config;
  }

  static PrintPlan plan(int count) {
    PrintPlan plan;
    plan.job = "box";
    const double height = to_millimeters(kLayer).count() * count;
    HeightIndex box(models::box({0, 0, 0}, {3, 2, static_cast<float>(height)}));
    plan.engine = std::make_unique<ContourEngine>(std::move(box), EngineSettings{.display = kDisplay},
                                                  std::vector{PixelMap::true_scale(kDisplay, {1.5, 1})});
    plan.layers = PrintLayers(LayerStack{kLayer, count});
    plan.expected_layers = plan.layers.all();
    plan.exposure = [](std::int32_t layer, Nanometers) { return 1s + 100ms * layer; };
    plan.pixel_area_mm2 = 0.01;
    plan.lift = Nanometers{6'000'000};
    plan.lift_speed = MillimetersPerSecond{2};
    plan.retract_speed = plan.travel_speed = plan.homing_speed = MillimetersPerSecond{5};
    plan.settle = 700ms;
    plan.rest = 300ms;
    return plan;
  }

  void start(int count = 3) { process.start(plan(count)); }

  // Makes the clock's calls until the state is reached; false when the print ends before.
  bool run_to(PrintState state) {
    while (process.state() != state) {
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

  void state_changed(PrintState state) override { states.push_back(state); }
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
  std::vector<PrintState> states;
  std::vector<LayerRecord> layers;
  std::vector<std::string> interruptions;
  std::vector<PrintOutcome> ends;
  std::string reason;
  bool light_at_end = false;
  bool gone_while_lit = false;
  bool lit_unknown = false;  // light on while the process takes it as off
  bool lit_wrongly = false;  // light on outside an exposure, or over a black screen
  PrintProcess process;

 private:
  bool step() {
    const bool more = clock.run_next();
    const bool may_be_lit =
        process.state() == PrintState::Igniting || process.state() == PrintState::Exposing;
    lit_unknown = lit_unknown || (machine.light_is_on() && !process.light_may_be_on());
    lit_wrongly = lit_wrongly || (machine.light_is_on() && (!may_be_lit || machine.screen_is_black()));
    return more;
  }
};

using S = PrintState;

constexpr PrintState kActiveStates[] = {
    S::WarmingUp, S::Homing,        S::Lowering,     S::Settling, S::Showing, S::Igniting,     S::Exposing,
    S::Darkening, S::Extinguishing, S::Interrupting, S::Resting,  S::Lifting, S::AwaitingDark, S::Raising,
    S::Paused,    S::Held,          S::Braking,      S::Halting,  S::Parking, S::Ending};

// Brings a print into a state.
void bring_to(Bench& bench, PrintState state) {
  bench.start();
  if (state == S::Raising || state == S::Paused) bench.process.pause();
  if (state == S::Held) bench.process.interrupt("the lid was opened");
  if (state == S::Interrupting) {
    REQUIRE(bench.run_to(S::Exposing));
    bench.process.interrupt("the lid was opened");
  }
  if (state == S::Braking) {
    REQUIRE(bench.run_to(S::Lowering));
    bench.process.interrupt("the lid was opened");
  }
  if (state == S::Halting) {
    REQUIRE(bench.run_to(S::Lifting));
    bench.process.cancel();
  }
  REQUIRE(bench.run_to(state));
}

}  // namespace

TEST_CASE("A homing as slow as it may be is waited for over the whole travel") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.axis.homing_speed = MillimetersPerSecond{0.1};
  config.axis.start_height = config.axis.travel;
  Bench bench(config);
  PrintPlan plan = Bench::plan(1);
  plan.homing_speed = config.axis.homing_speed;
  bench.process.start(std::move(plan));
  bench.run_out();
  CHECK(bench.reason.empty());
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A print goes through its states layer by layer and ends parked, done and dark") {
  Bench bench;
  bench.start(2);
  bench.run_out();
  const std::vector<S> layer{S::Lowering,  S::Settling,      S::Showing, S::Igniting, S::Exposing,
                             S::Darkening, S::Extinguishing, S::Resting, S::Lifting,  S::AwaitingDark};
  std::vector<S> expected{S::WarmingUp, S::Homing, S::AwaitingDark};
  for (int i = 0; i < 2; ++i)
    expected.insert(expected.end(), layer.begin(), layer.end());
  expected.insert(expected.end(), {S::Parking, S::Ending, S::Idle});
  CHECK(bench.states == expected);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(bench.lit_wrongly);
  CHECK_FALSE(bench.light_at_end);
  CHECK(bench.machine.z_axis().height() == bench.machine.z_axis().travel());
}

TEST_CASE("Light may be on from its command until it is confirmed off, and its layer is told then") {
  Bench bench;
  bench.start(2);
  // The layer has had its light, which is not confirmed off.
  REQUIRE(bench.run_to(S::Darkening));
  CHECK(bench.process.light_may_be_on());
  bench.process.interrupt("the lid was opened");
  CHECK(bench.process.light_may_be_on());
  CHECK(bench.layers.empty());
  REQUIRE(bench.run_to(S::Paused));
  CHECK_FALSE(bench.process.light_may_be_on());
  REQUIRE(bench.layers.size() == 1);
  CHECK(bench.layers[0].loops == 1);
  bench.process.resume();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(bench.lit_unknown);
  CHECK_FALSE(bench.gone_while_lit);
}

TEST_CASE("Each layer is exposed for exactly as long as was asked, at its own height") {
  Bench bench;
  bench.start(3);
  bench.run_out();
  REQUIRE(bench.layers.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const LayerRecord& layer = bench.layers[i];
    CHECK(layer.exposure_asked == 1s + 100ms * static_cast<int>(i));
    CHECK(layer.exposure_most == layer.exposure_asked);
    CHECK(layer.plate_height == kLayer * static_cast<std::int64_t>(i + 1));
    CHECK(layer.mask_height == layer.plate_height - kLayer / 2);
    // 3 mm by 2 mm at 0.1 mm a pixel: whole pixels, so exact.
    CHECK(layer.area_mm2 == contourd::testing::Approx(6.0).epsilon(1e-12));
    CHECK(layer.loops == 1);
    CHECK(layer.intersecting_facets == 8);
    CHECK(layer.cracks == LayerCracks{});
  }
}

TEST_CASE("A layer's record has the gaps that were closed in its mask") {
  Bench bench;
  PrintPlan plan = Bench::plan(2);
  models::Facets cracked = models::box({0, 0, 0}, {3, 2, 0.1F});
  for (Facet& facet : cracked) {
    const auto& v = facet.vertices;
    const bool front = v[0].y == 0 && v[1].y == 0 && v[2].y == 0;
    for (Vertex& vertex : facet.vertices)
      vertex.y -= front ? 0.02F : 0;
  }
  plan.engine = std::make_unique<ContourEngine>(HeightIndex(cracked), EngineSettings{.display = kDisplay},
                                                std::vector{PixelMap::true_scale(kDisplay, {1.5, 1})});
  ContourEngine alone(*plan.engine);
  bench.process.start(std::move(plan));
  bench.run_out();
  REQUIRE(bench.layers.size() == 2);
  for (const LayerRecord& layer : bench.layers) {
    const Contours& contours = alone.contours_at(layer.mask_height);
    CHECK(layer.cracks == contours.cracks);
    CHECK(layer.cracks.gaps_closed == 2);
    CHECK(layer.loops == contours.loops.size());
    CHECK(layer.intersecting_facets == 8);
  }
}

TEST_CASE("Layers of different thickness lie upon each other, each with the light for its own") {
  Bench bench;
  PrintPlan plan = Bench::plan(1);
  // A cone's point up: slopes of 45 degrees on a block.
  auto model = std::make_shared<const HeightIndex>(models::cone(2, 2, 64));
  plan.engine = std::make_unique<ContourEngine>(
      std::vector{PlateModel{{model}, {PixelMap::true_scale(kDisplay, {0, 0})}}},
      EngineSettings{kDisplay, AntiAliasing::On});
  plan.layers =
      PrintLayers({{model}, {std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 3}))}},
                  {Nanometers{20'000}, Nanometers{100'000}, Nanometers{35'000}});
  plan.expected_layers = plan.layers.all();
  plan.exposure = [](std::int32_t, Nanometers thickness) { return thickness.count() * 10us; };
  const std::vector<Nanometers> expected = plan.expected_layers;
  bench.process.start(std::move(plan));
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
  REQUIRE(bench.layers.size() == expected.size());
  Nanometers bottom{};
  std::set<Nanometers> thicknesses;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const LayerRecord& layer = bench.layers[i];
    CHECK(layer.bottom == bottom);
    CHECK(layer.thickness == expected[i]);
    CHECK(layer.exposure_most == layer.thickness.count() * 10us);
    bottom += layer.thickness;
    // A microstep of the simulated axis is 1.25 um: half of one at most.
    CHECK(std::abs((layer.plate_height - bottom).count()) <= 625);
    CHECK(layer.mask_height == layer.plate_height - layer.thickness / 2);
    thicknesses.insert(layer.thickness);
  }
  CHECK(bottom == Nanometers{3'000'000});
  // On the slope 35 um / cos 45 degrees, above it the thickest.
  CHECK(thicknesses.contains(Nanometers{49'000}));
  CHECK(thicknesses.contains(Nanometers{100'000}));
}

TEST_CASE("A print whose layers are not as expected goes on and ends where the layers end") {
  Bench bench;
  PrintPlan plan = Bench::plan(3);
  plan.expected_layers.resize(1);
  bench.process.start(std::move(plan));
  REQUIRE(bench.run_to(S::Lifting));
  const ZAxis& axis = bench.machine.z_axis();
  CHECK(bench.process.time_left() <= axis.move_duration(axis.travel(), MillimetersPerSecond{5}) + 3s);
  bench.run_out();
  CHECK(bench.layers.size() == 3);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("The mask belongs to the height that the plate has, not to the one that was asked") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.axis.microsteps_per_mm = 30;  // steps of 33 um: no layer of 50 um falls on one
  Bench bench(config);
  bench.start(3);
  bench.run_out();
  REQUIRE(bench.layers.size() == 3);
  CHECK(bench.layers[0].plate_height == Nanometers{66'667});
  for (const LayerRecord& layer : bench.layers)
    CHECK(layer.mask_height == layer.plate_height - kLayer / 2);
}

TEST_CASE("A failure in any state turns the light off, leaves the motor still and ends the print once") {
  for (const S state : kActiveStates) {
    CAPTURE(name_of(state));
    Bench bench;
    bring_to(bench, state);
    bench.process.fail("the sky fell");
    CHECK_FALSE(bench.machine.light_is_on());
    CHECK(bench.machine.screen_is_black());
    CHECK_FALSE(bench.machine.z_axis().moving());
    CHECK(bench.process.state() == S::Ending);
    bench.run_out();  // late answers from the machine change nothing
    CHECK(bench.process.state() == S::Idle);
    REQUIRE(bench.ends.size() == 1);
    CHECK_FALSE(bench.machine.light_is_on());
    if (state == S::Ending) continue;  // all had been done
    CHECK(bench.ends[0] == PrintOutcome::Failed);
    CHECK(bench.reason == "the sky fell");
  }
}

TEST_CASE(
    "A cancel in any state turns the light off at once, and the plate goes up where its position is known") {
  for (const S state : kActiveStates) {
    if (state == S::Halting || state == S::Parking || state == S::Ending) continue;  // cancelled, or done
    CAPTURE(name_of(state));
    Bench bench;
    bring_to(bench, state);
    bench.process.cancel();
    CHECK_FALSE(bench.machine.light_is_on());
    CHECK(bench.machine.screen_is_black());
    bench.run_out();
    CHECK(bench.process.state() == S::Idle);
    CHECK(bench.ends == std::vector{PrintOutcome::Canceled});
    CHECK_FALSE(bench.lit_wrongly);
    const bool position_known = state != S::WarmingUp && state != S::Homing && state != S::Held;
    if (position_known) CHECK(bench.machine.z_axis().height() == bench.machine.z_axis().travel());
  }
}

TEST_CASE("A cancel after the last layer does not undo the print") {
  Bench bench;
  bring_to(bench, S::Parking);
  bench.process.cancel();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE(
    "A pause waits for the layer under way, lifts the plate, and a resume goes on with the next layer") {
  Bench bench;
  bench.start(3);
  REQUIRE(bench.run_to(S::Exposing));
  bench.process.pause();
  CHECK(bench.process.pause_pending());
  REQUIRE(bench.run_to(S::Paused));
  CHECK(bench.layers.size() == 1);
  CHECK(bench.layers[0].exposure_most == bench.layers[0].exposure_asked);
  // Layer height, lift and 30 mm for a look.
  CHECK(bench.machine.z_axis().height() == Nanometers{36'050'000});
  bench.run_out();
  CHECK(bench.process.state() == S::Paused);
  bench.process.resume();
  bench.run_out();
  CHECK(bench.layers.size() == 3);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("When a pause comes is told in every state, and where the print ends before there is none") {
  const auto told = [](PrintState state) {
    Bench bench;
    bring_to(bench, state);
    return std::string(bench.process.next_pause());
  };
  for (const S state : {S::WarmingUp, S::Homing})
    CHECK(told(state) == "before the first layer");
  for (const S state : {S::Lowering, S::Settling, S::Showing, S::Igniting, S::Exposing, S::Darkening,
                        S::Extinguishing, S::Resting, S::Lifting})
    CHECK(told(state) == "after this layer");
  for (const S state : {S::Raising, S::Paused, S::Held})
    CHECK(told(state) == "now");
  for (const S state : {S::Interrupting, S::Braking})
    CHECK(told(state) == "when the plate is up");
  for (const S state : {S::Halting, S::Parking, S::Ending})
    CHECK(told(state).empty());
}

TEST_CASE("A print's only layer can be paused before it, not in it") {
  Bench bench;
  bench.start(1);
  REQUIRE(bench.run_to(S::Homing));
  CHECK(bench.process.next_pause() == "before the first layer");
  REQUIRE(bench.run_to(S::Exposing));
  CHECK(bench.process.next_pause().empty());
  bench.process.interrupt("the lid was opened");
  CHECK(bench.process.next_pause() == "when the plate is up");
  REQUIRE(bench.run_to(S::Paused));
}

TEST_CASE("A resume while the plate still rises for the pause goes on as soon as it is up") {
  Bench bench;
  bring_to(bench, S::Raising);
  bench.process.resume();
  bench.run_out();
  CHECK(std::count(bench.states.begin(), bench.states.end(), S::Paused) == 1);
  CHECK(bench.layers.size() == 3);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A resume before the pause has come takes the pause back") {
  Bench bench;
  bench.start(2);
  bench.process.pause();
  bench.process.resume();
  bench.run_out();
  CHECK(std::count(bench.states.begin(), bench.states.end(), S::Paused) == 0);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
}

TEST_CASE("A limit switch that never closes ends the print with its name") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.axis.limit_switch = SimulatedAxisConfig::Switch::StuckOpen;
  Bench bench(config);
  bench.start();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Failed});
  CHECK(bench.reason == "homing failed: the limit switch did not trigger after the full travel");
}

TEST_CASE(
    "A display lost during the print pauses it in the dark, with the plate up, until the owner resumes") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.display.lost_after_frames = 1;
  Bench bench(config);
  bench.start();
  bench.run_out();
  CHECK(bench.process.state() == S::Paused);
  CHECK(bench.process.interruption() == "the display was unplugged");
  CHECK(bench.machine.why_not_ready() == "the display is unplugged");
  CHECK(bench.layers.size() == 1);
  CHECK_FALSE(bench.machine.light_is_on());
  // Two layers, lift and 30 mm for a look.
  CHECK(bench.machine.z_axis().height() == Nanometers{36'100'000});
  bench.machine.plug_display();
  CHECK(bench.process.state() == S::Paused);
  bench.process.resume();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
  CHECK(bench.layers.size() == 3);
  CHECK_FALSE(bench.lit_wrongly);
}

TEST_CASE("A print resumed while the display is still gone exposes nothing and pauses again") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.display.lost_after_frames = 1;
  Bench bench(config);
  bench.start();
  bench.run_out();
  bench.process.resume();
  CHECK(bench.process.interruption().empty());
  bench.run_out();
  CHECK(bench.process.state() == S::Paused);
  CHECK(bench.process.interruption() == "the display was lost");
  CHECK(bench.layers.size() == 1);
  bench.process.cancel();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Canceled});
  CHECK_FALSE(bench.lit_wrongly);
}

TEST_CASE(
    "A mask that does not keep its budget is abandoned: dark, told with its figures, and tried again on "
    "resume") {
  Bench bench;
  PrintPlan plan = Bench::plan(3);
  plan.mask_budget = Duration{0};
  bench.process.start(std::move(plan));
  for (std::size_t times = 1; times <= 2; ++times) {
    bench.run_out();
    CHECK(bench.process.state() == S::Paused);
    REQUIRE(bench.interruptions.size() == times);
    CAPTURE(bench.interruptions.back());
    CHECK(bench.interruptions.back().find("the mask at 0.025 mm was abandoned") == 0);
    CHECK(bench.interruptions.back().find("mask_budget_ms, 0 ms") != std::string::npos);
    CHECK(bench.interruptions.back().find("8 facets cut") != std::string::npos);
    CHECK(std::ranges::count(bench.states, S::Igniting) == 0);
    CHECK(bench.machine.screen_is_black());
    bench.process.resume();
  }
  bench.process.cancel();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Canceled});
  CHECK(bench.layers.empty());
  CHECK_FALSE(bench.lit_wrongly);
}

TEST_CASE("An exposure that is interrupted goes on with what is left of it, at the same layer") {
  Bench bench;
  bench.start(2);
  REQUIRE(bench.run_to_light());
  const TimePoint lit = bench.clock.now();
  const auto opening = bench.clock.call_at(lit + 400ms, [&] { bench.machine.open_lid(); });
  while (bench.machine.light_is_on())
    REQUIRE(bench.clock.run_next());
  CHECK(bench.clock.now() == lit + 400ms);
  CHECK(bench.machine.screen_is_black());
  REQUIRE(bench.run_to(S::Paused));
  CHECK(bench.process.interruption() == "the lid was opened");
  CHECK(bench.interruptions == std::vector<std::string>{"the lid was opened"});
  CHECK(bench.layers.empty());
  CHECK(bench.process.layer() == 0);
  bench.machine.close_lid();
  bench.process.resume();
  REQUIRE(bench.run_to_light());
  CHECK(bench.machine.z_axis().height() == kLayer);
  const TimePoint lit_again = bench.clock.now();
  REQUIRE(bench.run_to(S::Darkening));
  CHECK(bench.clock.now() == lit_again + 600ms);
  bench.run_out();
  REQUIRE(bench.layers.size() == 2);
  CHECK(bench.layers[0].exposure_most == 1s);
  CHECK(bench.layers[0].exposure_parts == 2);
  CHECK(bench.layers[1].exposure_most == 1100ms);
  CHECK(bench.layers[1].exposure_parts == 1);
  CHECK(bench.ends == std::vector{PrintOutcome::Done});
  CHECK_FALSE(bench.lit_wrongly);
}

TEST_CASE("A light that somebody else turns off in an exposure interrupts it, and is not taken for given") {
  for (const bool told : {false, true}) {
    Bench bench;
    bench.start(1);
    REQUIRE(bench.run_to(S::Igniting));
    const auto off = bench.clock.call_after(300ms, [&] { bench.machine.projector().light_off(); });
    // Heard of when the exposure is to end, before that is seen to.
    const TimePoint end = bench.machine.projector().last_light().value().on_earliest + 1s;
    const auto word = bench.clock.call_at(end, [&] {
      if (told) bench.process.interrupt("the light watchdog has turned the light off");
    });
    REQUIRE(bench.run_to(S::Paused));
    CHECK(bench.interruptions.size() == 1);
    CHECK(bench.layers.empty());
    bench.process.resume();
    bench.run_out();
    REQUIRE(bench.layers.size() == 1);
    CHECK(bench.ends == std::vector{PrintOutcome::Done});
    CHECK(bench.layers[0].exposure_parts == 2);
    CHECK(bench.layers[0].complete);
    // A turn of the loop lies between light on and what is known of it.
    CHECK(bench.layers[0].exposure_most - 1s < 1ms);
    CHECK(1s - bench.layers[0].exposure_least < 1ms);
  }
}

TEST_CASE("An exposure interrupted three times adds up to what was asked") {
  Bench bench;
  bench.start(1);
  for (const Duration until : {100ms, 250ms, 1ms}) {
    REQUIRE(bench.run_to(S::Exposing));
    const auto opening = bench.clock.call_after(until, [&] { bench.machine.open_lid(); });
    REQUIRE(bench.run_to(S::Paused));
    bench.process.resume();
  }
  bench.run_out();
  REQUIRE(bench.layers.size() == 1);
  CHECK(bench.layers[0].exposure_most == 1s);
  CHECK(bench.layers[0].exposure_parts == 4);
}

TEST_CASE(
    "An interruption in any state turns the light off at once, and the print can be finished or cancelled") {
  for (const S state : kActiveStates) {
    for (const bool resumed : {true, false}) {
      CAPTURE(name_of(state), resumed);
      Bench bench;
      bring_to(bench, state);
      bench.process.interrupt("the cat jumped on it");
      CHECK_FALSE(bench.machine.light_is_on());
      CHECK(bench.machine.screen_is_black());
      bench.run_out();
      CHECK_FALSE(bench.lit_wrongly);
      if (state == S::Halting || state == S::Parking || state == S::Ending) {
        CHECK(bench.process.state() == S::Idle);  // was about to end, and did
        continue;
      }
      CHECK((bench.process.state() == S::Paused || bench.process.state() == S::Held));
      CHECK_FALSE(bench.process.pause_pending());
      CHECK(bench.process.interruption().ends_with("the cat jumped on it"));
      resumed ? bench.process.resume() : bench.process.cancel();
      bench.run_out();
      CHECK(bench.ends == std::vector{resumed ? PrintOutcome::Done : PrintOutcome::Canceled});
      if (!resumed) continue;
      REQUIRE(bench.layers.size() == 3);
      for (const LayerRecord& layer : bench.layers)
        CHECK(layer.exposure_most == layer.exposure_asked);
    }
  }
}

TEST_CASE("The last layer's exposure is finished too when it was interrupted") {
  for (const S state : {S::Exposing, S::Darkening, S::Lifting}) {
    CAPTURE(name_of(state));
    Bench bench;
    bench.start(1);
    REQUIRE(bench.run_to(state));
    bench.process.interrupt("the lid was opened");
    bench.run_out();
    CHECK(bench.process.state() == S::Paused);
    bench.process.resume();
    bench.run_out();
    CHECK(bench.ends == std::vector{PrintOutcome::Done});
    REQUIRE(bench.layers.size() == 1);
    CHECK(bench.layers[0].exposure_most == bench.layers[0].exposure_asked);
  }
}

TEST_CASE("An interruption at the instant at which an exposure ends leaves no rest of it") {
  Bench bench;
  bench.start(2);
  REQUIRE(bench.run_to(S::Igniting));
  // Asked for before the exposure's timer, so it comes first.
  const auto opening = bench.clock.call_after(20ms + 1s, [&] { bench.machine.open_lid(); });
  REQUIRE(bench.run_to(S::Paused));
  CHECK(bench.layers.size() == 1);
  bench.process.resume();
  bench.run_out();
  REQUIRE(bench.layers.size() == 2);
  CHECK(bench.layers[0].exposure_most == 1s);
  CHECK(bench.layers[0].exposure_parts == 1);
}

TEST_CASE("A resume while an interrupted plate is still being lifted does not skip the layer") {
  Bench bench;
  bench.start(2);
  REQUIRE(bench.run_to(S::Exposing));
  bench.machine.open_lid();
  CHECK(bench.process.state() == S::Interrupting);
  REQUIRE(bench.run_to(S::Lifting));
  CHECK(bench.process.pause_pending());
  bench.process.resume();
  bench.run_out();
  CHECK(std::count(bench.states.begin(), bench.states.end(), S::Paused) == 0);
  REQUIRE(bench.layers.size() == 2);
  CHECK(bench.layers[0].exposure_most == 1s);
}

TEST_CASE("What interrupts a print twice is told once, and two things are both told") {
  Bench bench;
  bench.start();
  REQUIRE(bench.run_to(S::Settling));
  bench.process.interrupt("the lid was opened");
  bench.process.interrupt("the lid was opened");
  bench.process.interrupt("HDMI-A-1 was unplugged");
  CHECK(bench.process.interruption() == "the lid was opened; HDMI-A-1 was unplugged");
  CHECK(bench.interruptions.size() == 2);
}

TEST_CASE("An interruption where the plate's position has been lost ends the print, with the light off") {
  Bench bench;
  bench.start();
  REQUIRE(bench.run_to(S::Lowering));
  bench.machine.z_axis().abort();
  bench.process.interrupt("the lid was opened");
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Failed});
  CHECK_FALSE(bench.light_at_end);
}

TEST_CASE("A pressed emergency stop ends the print at once, with its sentence") {
  for (const S state : kActiveStates) {
    CAPTURE(name_of(state));
    Bench bench;
    bring_to(bench, state);
    bench.machine.press_emergency_stop();
    CHECK_FALSE(bench.machine.light_is_on());
    CHECK_FALSE(bench.machine.z_axis().moving());
    CHECK(bench.process.state() == S::Ending);
    bench.run_out();
    if (state == S::Ending) continue;
    CHECK(bench.ends == std::vector{PrintOutcome::Failed});
    CHECK(bench.reason == "the emergency stop was pressed");
  }
}

TEST_CASE("A projector that falls silent ends the print, with the light off") {
  SimulatedPrinterConfig config = Bench::small_printer();
  config.projector.silent_after_commands = 2;  // power on and the first light on
  Bench bench(config);
  bench.start();
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Failed});
  CHECK(bench.reason == "waited 30 s in vain for the projector to confirm that its light is off");
  REQUIRE(bench.layers.size() == 2);
  CHECK(bench.layers[0].dark_confirmed);
  CHECK_FALSE(bench.layers[1].dark_confirmed);
  CHECK(bench.layers[1].exposure_least == Duration{0});
  CHECK(bench.layers[1].exposure_most > 30s);
  CHECK_FALSE(bench.light_at_end);
}

namespace {

// An axis that homes, and then never answers again.
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
  explicit DeafMachine(Clock& clock) : axis(clock), rest_(clock, Bench::small_printer()) {}
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

// One whose projector was lost, and another was found.
class ChangedMachine final : public Machine {
 public:
  explicit ChangedMachine(Clock& clock)
      : before(clock, Bench::small_printer()), after(clock, Bench::small_printer()) {}
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

TEST_CASE("A projector found in place of a lost one does not answer for that one's light") {
  Bench observer;
  VirtualClock clock;
  ChangedMachine machine(clock);
  // Ten seconds of the other's own.
  Projector& other = machine.after.projector();
  other.power_on([](ProjectorReply) {});
  while (clock.run_next()) {
  }
  other.light_on(10s, {.sent = [](TimePoint) {}, .done = [](ProjectorReply) {}});
  const auto off = clock.call_after(10s, [&other] { other.light_off(); });
  while (clock.run_next()) {
  }
  PrintProcess process(machine, clock, observer);
  process.start(Bench::plan(1));
  while (process.state() != S::Exposing)
    REQUIRE(clock.run_next());
  REQUIRE(other.last_light());
  process.fail("the serial port was lost");
  machine.changed = true;
  SECTION("whatever happens before the print is over") {
    process.interrupt("the emergency stop was touched");
  }
  SECTION("nor when nothing more happens") {}
  while (clock.run_next()) {
  }
  REQUIRE(observer.layers.size() == 1);
  CHECK(observer.layers[0].exposure_least < 1s);
  CHECK(observer.layers[0].exposure_most < 1s);
}

TEST_CASE(
    "A move that never ends fails the print after its expected time, a tenth and 15 s, and is aborted") {
  Bench observer;
  VirtualClock clock;
  DeafMachine machine(clock);
  PrintProcess process(machine, clock, observer);
  machine.axis.aborted = false;
  process.start(Bench::plan(1));
  while (clock.run_next()) {
  }
  CHECK(observer.ends == std::vector{PrintOutcome::Failed});
  CHECK(observer.reason == "waited 26 s in vain for a move to end");
  CHECK(machine.axis.aborted);
}

TEST_CASE("A cancelled move that never stops fails the print instead of holding it for ever") {
  Bench observer;
  VirtualClock clock;
  DeafMachine machine(clock);
  PrintProcess process(machine, clock, observer);
  process.start(Bench::plan(1));
  while (process.state() != S::Lowering)
    REQUIRE(clock.run_next());
  machine.axis.aborted = false;
  process.cancel();
  CHECK(process.state() == S::Halting);
  while (clock.run_next()) {
  }
  CHECK(observer.reason == "waited 15 s in vain for the axis to stop");
  CHECK(machine.axis.aborted);
}

TEST_CASE("A mask that cannot be shown ends the print with the reason, with the light off") {
  const TemporaryFolder folder;
  SimulatedPrinterConfig config = Bench::small_printer();
  config.display.masks = folder.path() / "masks";
  Bench bench(config);
  const auto masks = bench.machine.begin_job("box");
  REQUIRE(masks);
  bench.start();
  REQUIRE(bench.run_to(S::Resting));
  std::filesystem::remove_all(*masks);
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Failed});
  CHECK(bench.reason.find("cannot write") != std::string::npos);
  CHECK_FALSE(bench.machine.light_is_on());
  CHECK(bench.machine.screen_is_black());
}

TEST_CASE("The process leaves the light off when it is destroyed in the middle of an exposure") {
  VirtualClock clock;
  SimulatedPrinter machine(clock, Bench::small_printer());
  {
    Bench unused;  // only to observe
    PrintProcess process(machine, clock, unused);
    process.start(Bench::plan(1));
    while (!machine.light_is_on())
      REQUIRE(clock.run_next());
  }
  while (clock.run_next()) {
  }  // what it waited for is not told to what is gone
  CHECK_FALSE(machine.light_is_on());
  CHECK(machine.screen_is_black());
}

TEST_CASE("The time left is what the print really takes, with warm-up, homing and parking") {
  Bench bench;
  PrintPlan plan = Bench::plan(3);
  plan.warm_up = 5s;  // the simulated projector's
  bench.process.start(std::move(plan));
  const Duration expected = bench.process.time_left();
  const TimePoint start = bench.clock.now();
  REQUIRE(bench.run_to(S::Ending));
  const Duration real = bench.clock.now() - start;
  // It stood at 40 mm, which nobody knew, and not where a print parks it.
  const ZAxis& axis = bench.machine.z_axis();
  const Duration sooner = axis.move_duration(axis.travel(), MillimetersPerSecond{5}) -
                          axis.move_duration(Nanometers{40'000'000}, MillimetersPerSecond{5});
  // Two frames and two replies a layer are not in the estimate, nor that retracts are a layer shorter.
  CHECK(std::chrono::abs(real - (expected - sooner)) < 3 * (2 * 17ms + 2 * 20ms) + 100ms);
}

TEST_CASE("The time left counts down in every state that takes its time") {
  Bench bench;
  PrintPlan plan = Bench::plan(1);
  plan.warm_up = 5s;
  bench.process.start(std::move(plan));
  const auto state = GENERATE(S::WarmingUp, S::Homing, S::Lowering, S::Settling, S::Exposing, S::Resting,
                              S::Lifting, S::Parking);
  REQUIRE(bench.run_to(state));
  INFO(name_of(state));
  const Duration total = bench.process.time_left();
  const Duration in_state = bench.process.state_left().value();
  REQUIRE(in_state > 50ms);
  bool looked = false;
  const auto look = bench.clock.call_after(50ms, [&] {
    looked = true;
    CHECK(bench.process.time_left() == total - 50ms);
    CHECK(bench.process.state_left() == in_state - 50ms);
  });
  while (!looked)
    REQUIRE(bench.clock.run_next());
}

TEST_CASE("The time left waits while the print waits for its owner") {
  Bench bench;
  bring_to(bench, S::Paused);
  CHECK_FALSE(bench.process.state_left());
  const Duration left = bench.process.time_left();
  bool looked = false;
  const auto look = bench.clock.call_after(1min, [&looked] { looked = true; });
  while (!looked)
    REQUIRE(bench.clock.run_next());
  CHECK(bench.process.time_left() == left);
}

TEST_CASE("Of a print that is cancelled only parking is left") {
  Bench bench;
  bench.start(100);
  REQUIRE(bench.run_to(S::Lifting));
  bench.process.cancel();
  const ZAxis& axis = bench.machine.z_axis();
  const Duration whole = axis.move_duration(axis.travel(), MillimetersPerSecond{5});
  CHECK(bench.process.time_left() <= whole + 1s);
  CHECK(bench.process.time_left() > whole / 2);
}

TEST_CASE("A second print follows the first on the same machine") {
  Bench bench;
  bench.start(1);
  bench.run_out();
  bench.start(2);
  bench.run_out();
  CHECK(bench.ends == std::vector{PrintOutcome::Done, PrintOutcome::Done});
  CHECK(bench.layers.size() == 3);
}
