// Tests of an axis with emergency stop, lid, and inputs that cannot be read.

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/random_shapes.hpp"

namespace {

using Kind = MachineEvent::Kind;
using Sentences = std::vector<std::string>;

// Returns an axis that has all inputs, with 5 ms of debouncing each.
GpioAxisConfig guarded_config() {
  GpioAxisConfig config = testing::with_second_switch();
  config.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}};
  config.lid = GpioInputConfig{{"gpiochip0", "6", false}};
  return config;
}

constexpr Duration kAxisDebounce = 5ms;

std::vector<Kind> kinds(const Plant& plant) {
  std::vector<Kind> all;
  for (const MachineEvent& event : plant.events)
    all.push_back(event.kind);
  return all;
}
using Kinds = std::vector<Kind>;

// Presses an input at a time from now for `lasting`.
class Press {
 public:
  Press(Plant& plant, AxisInput which, Duration at, Duration lasting)
      : press_(plant.clock.call_after(at,
                                      [this, &plant, which] {
                                        at_ = plant.clock.now();
                                        made_ = plant.pulses.size();
                                        plant.press(which, true);
                                      })),
        release_(plant.clock.call_after(at + lasting, [&plant, which] { plant.press(which, false); })) {}

  [[nodiscard]] TimePoint at() const { return at_; }
  // The number of steps since the press.
  [[nodiscard]] std::size_t steps_since(const Plant& plant) const { return plant.pulses.size() - made_; }

 private:
  TimePoint at_{};
  std::size_t made_ = 0;
  std::unique_ptr<Timer> press_, release_;
};

constexpr Duration kForGood = 1000s;

}  // namespace

TEST_CASE("An emergency stop slows the motor from its first edge on, and halts it if it lasts") {
  HomedPlant plant(guarded_config());
  bool answered_before = true;
  plant.on_event = [&] { answered_before = !plant.axis->moving(); };
  const Press press(plant, AxisInput::EmergencyStop, 2s, kForGood);
  CHECK(plant.move_to(50) == MoveResult::Fault);
  CHECK_FALSE(answered_before);  // the event comes before the move's answer
  // No step is made after the debounce time and 60 us for the thread to wake.
  CHECK(plant.pulses.back() - press.at() <= kAxisDebounce + 60us);
  // Slower from the first edge on: 5 mm/s less 50 mm/s^2 for 5 ms is a twentieth, half of it on average, of
  // 20 steps.
  CHECK(press.steps_since(plant) <= 20);
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Fault});
  CHECK(plant.events[0].what ==
        "the emergency stop was touched, or its line disturbed (line 5 of gpiochip0)");
  CHECK(plant.events[1].what == "the emergency stop is pressed (line 5 of gpiochip0)");
  CHECK_FALSE(plant.events[0].needs_user);
  CHECK(plant.events[1].needs_user);
  CHECK_FALSE(plant.axis->height());
}

TEST_CASE("An emergency stop halts the motor while the event loop is busy, and the fault is reported later") {
  HomedPlant plant(guarded_config());
  std::optional<MoveResult> result;
  plant.axis->move_to(mm(50), MillimetersPerSecond{5}, [&](MoveResult r) { result = r; });
  plant.run_for(2s);
  const TimePoint pressed = plant.clock.now();
  plant.press(AxisInput::EmergencyStop, true);
  plant.run_threads_for(1s);
  CHECK(plant.pulses.back() - pressed <= kAxisDebounce + 60us);
  plant.run([&] { return result.has_value(); });
  CHECK(result == MoveResult::Fault);
  CHECK(kinds(plant) == Kinds{Kind::Fault});
}

TEST_CASE("While the emergency stop is pressed nothing moves, and after its release the operator decides") {
  BuiltPlant plant(guarded_config());
  plant.press(AxisInput::EmergencyStop, true);
  plant.run_for(100ms);
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Fault});
  CHECK(plant.axis->why_not_ready() == Sentences{"the emergency stop is pressed"});
  plant.events.clear();
  CHECK(plant.home() == HomingResult::Fault);
  CHECK(plant.pulses.empty());
  CHECK(kinds(plant) == Kinds{Kind::Fault});
  plant.events.clear();
  plant.press(AxisInput::EmergencyStop, false);
  plant.run_for(100ms);
  REQUIRE(kinds(plant) == Kinds{Kind::Recovery});
  CHECK(plant.events[0].what == "the emergency stop was released (line 5 of gpiochip0)");
  CHECK(plant.events[0].needs_user);  // the motor does not start by itself
  CHECK(plant.axis->why_not_ready().empty());
  CHECK(plant.home() == HomingResult::Homed);
}

TEST_CASE("The callback for an emergency stop may abort the move, whose answer is then dropped") {
  HomedPlant plant(guarded_config());
  bool answered = false;
  plant.on_event = [&] { plant.axis->abort(); };
  plant.axis->move_to(mm(50), MillimetersPerSecond{5}, [&](MoveResult) { answered = true; });
  plant.run_for(1s);
  plant.press(AxisInput::EmergencyStop, true);
  plant.run_for(1s);
  CHECK_FALSE(answered);
  CHECK_FALSE(plant.axis->moving());
}

TEST_CASE("A spike on the emergency stop's line stops a move, which then continues with a known position") {
  HomedPlant plant(guarded_config());
  const Press spike(plant, AxisInput::EmergencyStop, 2s, 1ms);
  CHECK(plant.move_to(20) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 16'000);
  CHECK(plant.axis->height() == mm(20));
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Recovery});
  CHECK(plant.events[1].what == "the emergency stop is not pressed (line 5 of gpiochip0)");
  CHECK_FALSE(plant.events[1].needs_user);
  // The motor slows down from 5 mm/s at 50 mm/s^2, which takes a tenth of a second, and speeds up again. In
  // between one interval is that of a very slow motor.
  const auto slowest = [&] {
    Duration longest{};
    for (std::size_t i = 1; i < plant.pulses.size(); ++i) {
      if (plant.pulses[i - 1] > spike.at() && plant.pulses[i] < spike.at() + 1s)
        longest = std::max(longest, plant.pulses[i] - plant.pulses[i - 1]);
    }
    return longest;
  }();
  CHECK(slowest > 1ms);
  CHECK(slowest < 50ms);
}

TEST_CASE("No step is made before it is known whether the emergency stop is pressed") {
  HomedPlant plant(guarded_config());
  const bool lasts = GENERATE(false, true);
  plant.pulses.clear();
  const Press press(plant, AxisInput::EmergencyStop, 1ms, lasts ? kForGood : Duration{2ms});
  plant.run_for(1ms);
  plant.run_for(100us);  // the edge has been served
  CHECK(plant.axis->why_not_ready() == Sentences{"the emergency stop is pressed"});
  CHECK(plant.move_to(1) == (lasts ? MoveResult::Fault : MoveResult::Reached));
  if (lasts) {
    CHECK(plant.pulses.empty());
    return;
  }
  CHECK(plant.pulses.front() - press.at() >= 2ms + kAxisDebounce);
  CHECK(plate_above_switch(plant) == 800);
}

TEST_CASE("A move that a spike has stopped does not continue before the spike is over") {
  GpioAxisConfig c = guarded_config();
  c.acceleration = MillimetersPerSecondSquared{5'000};  // at rest from 5 mm/s within a millisecond
  HomedPlant plant(c);
  const Press spike(plant, AxisInput::EmergencyStop, 2s, 4ms);
  CHECK(plant.move_to(20) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 16'000);
  const TimePoint rested = spike.at() + 1ms + 1ms,
                  over = spike.at() + 4ms + kAxisDebounce;  // 1 ms of latency
  for (const TimePoint step : plant.pulses)
    REQUIRE((step <= rested || step >= over));
}

TEST_CASE("A move that waits for the emergency stop to settle can be stopped and aborted") {
  HomedPlant plant(guarded_config());
  plant.pulses.clear();
  std::optional<MoveResult> result;
  const Press press(plant, AxisInput::EmergencyStop, 0ms, 4ms);
  plant.run_for(1ms);
  plant.axis->move_to(mm(1), MillimetersPerSecond{5}, [&](MoveResult r) { result = r; });
  const bool aborts = GENERATE(false, true);
  aborts ? plant.axis->abort() : plant.axis->stop();
  plant.run_for(1s);
  CHECK(result == (aborts ? std::nullopt : std::optional(MoveResult::Stopped)));
  CHECK(plant.pulses.empty());
  CHECK_FALSE(plant.axis->moving());
}

TEST_CASE(
    "A move that is stopped because of a spike ends there, and the next one waits for the spike's end") {
  HomedPlant plant(guarded_config());
  REQUIRE(plant.move_to(30) == MoveResult::Reached);
  plant.on_event = [&] { plant.axis->stop(); };  // like a print on its way down
  const Press spike(plant, AxisInput::EmergencyStop, 1s, 1ms);
  CHECK(plant.move_to(10) == MoveResult::Stopped);
  plant.on_event = nullptr;
  CHECK(plant.axis->height() == Nanometers{plate_above_switch(plant) * 1'250});
  CHECK(plant.move_to(31) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 24'800);
}

TEST_CASE("A spike while homing does not shift the position that it finds") {
  CHECK(rc::check([] {
    Plant plant(guarded_config());
    plant.limit.bounces = static_cast<int>(draw(0, 4));
    plant.limit.bounce = 200us;
    plant.build();
    std::vector<std::unique_ptr<Press>> spikes;
    for (auto count = draw(1, 3); count > 0; --count)
      spikes.push_back(std::make_unique<Press>(plant, AxisInput::EmergencyStop,
                                               std::chrono::milliseconds{count * 1'500 - draw(100, 1'500)},
                                               std::chrono::microseconds{draw(10, 1'500)}));
    RC_ASSERT(plant.home() == HomingResult::Homed);
    RC_ASSERT(plate_above_switch(plant) == 0);
    for (const MachineEvent& event : plant.events)
      RC_ASSERT(event.kind != Kind::Fault);
  }));
}

TEST_CASE("An abort because of a spike while homing leaves an axis that can be homed again") {
  BuiltPlant plant(guarded_config());
  plant.on_event = [&] { plant.axis->abort(); };  // like a print, which is held then
  const Press spike(plant, AxisInput::EmergencyStop, 500ms, 1ms);
  bool answered = false;
  plant.axis->home([&](HomingResult) { answered = true; });
  plant.run_for(1s);
  CHECK_FALSE(answered);
  CHECK_FALSE(plant.axis->moving());
  CHECK(plant.axis->why_not_ready().empty());
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE(
    "Moves with spikes on both safety inputs end where they should, and only interruptions are reported") {
  CHECK(rc::check([] {
    BuiltPlant plant(guarded_config());
    RC_ASSERT(plant.home() == HomingResult::Homed);
    std::vector<std::unique_ptr<Press>> spikes;
    for (auto count = draw(1, 6); count > 0; --count) {
      // At least 20 ms apart: two spikes within the debounce time count as a press.
      spikes.push_back(std::make_unique<Press>(
          plant, draw(0, 1) == 0 ? AxisInput::EmergencyStop : AxisInput::Lid,
          std::chrono::milliseconds{count * 300 + draw(0, 280)}, std::chrono::microseconds{draw(10, 4'900)}));
    }
    RC_ASSERT(plant.move_to(6) == MoveResult::Reached);
    RC_ASSERT(plant.move_to(2) == MoveResult::Reached);
    plant.run_for(3s);
    RC_ASSERT(plate_above_switch(plant) == 1'600);
    RC_ASSERT(plant.axis->height() == mm(2));
    RC_ASSERT(plant.axis->why_not_ready().empty());
    RC_ASSERT(plant.events.size() == 2 * spikes.size());
    for (std::size_t i = 0; i < plant.events.size(); ++i)
      RC_ASSERT(plant.events[i].kind == (i % 2 == 0 ? Kind::Interlock : Kind::Recovery));
  }));
}

TEST_CASE("An emergency stop that chatters for longer than its debounce time counts as pressed, once") {
  HomedPlant plant(guarded_config());
  std::vector<std::unique_ptr<Press>> touches;
  for (int i = 0; i < 1'000; ++i)
    touches.push_back(std::make_unique<Press>(plant, AxisInput::EmergencyStop, 2s + i * 4ms, 300us));
  CHECK(plant.move_to(50) == MoveResult::Fault);
  CHECK(plant.pulses.back() - touches[0]->at() <= 8ms + 60us);  // the first touch at 5 ms or later
  plant.run_for(5s);
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Fault, Kind::Recovery});
}

TEST_CASE("A spike while nothing moves blocks moves until it has settled, and is reported") {
  BuiltPlant plant(guarded_config());
  const Press spike(plant, AxisInput::EmergencyStop, 1ms, 1ms);
  plant.run_for(3ms);
  CHECK(plant.axis->why_not_ready() == Sentences{"the emergency stop is pressed"});
  plant.run_for(10ms);
  CHECK(plant.axis->why_not_ready().empty());
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Recovery});
}

TEST_CASE("Lid and emergency stop together are two interruptions and one fault") {
  HomedPlant plant(guarded_config());
  const Press lid(plant, AxisInput::Lid, 1s, 2s), stop(plant, AxisInput::EmergencyStop, 1s, 2s);
  CHECK(plant.move_to(50) == MoveResult::Fault);
  CHECK(plant.axis->why_not_ready() == Sentences{"the emergency stop is pressed", "the lid is open"});
  plant.run_for(3s);
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Interlock, Kind::Fault, Kind::Recovery, Kind::Recovery});
  CHECK(plant.axis->why_not_ready().empty());
}

TEST_CASE("An open lid is one interruption, which ends when it closes, and the motor does not stop") {
  HomedPlant plant(guarded_config());
  const Duration lasting = GENERATE(Duration{1ms}, Duration{2s});
  const Press open(plant, AxisInput::Lid, 1s, lasting);
  CHECK(plant.move_to(20) == MoveResult::Reached);
  REQUIRE(kinds(plant) == Kinds{Kind::Interlock, Kind::Recovery});
  CHECK(plant.events[0].what == "the lid was opened (line 6 of gpiochip0)");
  CHECK(plant.events[1].what == "the lid was closed (line 6 of gpiochip0)");
  CHECK(plant.axis->why_not_ready().empty());
}

TEST_CASE("A safety input that cannot be read is reported and prevents a print") {
  HomedPlant plant(guarded_config());
  plant.lines[static_cast<std::size_t>(AxisInput::Lid)]->unreadable = true;
  plant.run_for(100ms);
  CHECK(kinds(plant) == Kinds{Kind::Interlock});
  CHECK(plant.events[0].what == "the lid cannot be read, which counts as open (line 6 of gpiochip0)");
  CHECK(plant.axis->why_not_ready() == Sentences{"the lid cannot be read"});
  plant.lines[static_cast<std::size_t>(AxisInput::Lid)]->unreadable = false;
  plant.run_for(100ms);
  CHECK(plant.axis->why_not_ready().empty());
  plant.events.clear();

  plant.lines[static_cast<std::size_t>(AxisInput::EmergencyStop)]->unreadable = true;
  CHECK(plant.move_to(10) == MoveResult::Fault);
  CHECK(kinds(plant) == Kinds{Kind::Interlock, Kind::Fault});
  CHECK(plant.events[0].what == "the emergency stop cannot be read (line 5 of gpiochip0)");
  CHECK(plant.events[1].what == "the emergency stop cannot be read (line 5 of gpiochip0)");
  CHECK(plant.axis->why_not_ready() == Sentences{"the emergency stop cannot be read"});
}

TEST_CASE("A limit switch that cannot be read ends a move and homing with one fault that names it") {
  BuiltPlant plant(guarded_config());
  const AxisInput which = GENERATE(AxisInput::LimitSwitch, AxisInput::SecondSwitch);
  const bool homes = GENERATE(false, true);
  if (!homes) REQUIRE(plant.home() == HomingResult::Homed);
  const auto breaks =
      plant.clock.call_after(500ms, [&] { plant.lines[static_cast<std::size_t>(which)]->unreadable = true; });
  plant.pulses.clear();
  if (homes) {
    CHECK(plant.home() == HomingResult::Fault);
  } else {
    CHECK(plant.move_to(50) == MoveResult::Fault);
  }
  REQUIRE(kinds(plant) == Kinds{Kind::Fault});
  CHECK(plant.events[0].what == (which == AxisInput::LimitSwitch
                                     ? "the limit switch cannot be read (line 23 of gpiochip0)"
                                     : "the second switch cannot be read (line 24 of gpiochip0)"));
  CHECK(plant.axis->lost());
  CHECK_FALSE(plant.axis->height());
  plant.run_for(1s);
  CHECK(plant.events.size() == 1);
}
