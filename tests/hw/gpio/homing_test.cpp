// Tests of Homing alone: the test records its calls to the axis and sets the motor's state.
#include "hw/gpio/homing.hpp"

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

// 5 ms of debouncing, 100 mm of travel, 5 mm/s.
GpioAxisConfig axis_config(bool encoder = false) {
  GpioAxisConfig config;
  config.travel = Nanometers{100'000'000};
  if (encoder) config.encoder = EncoderConfig{};
  return config;
}

std::string millimeters_at(const char* what, Nanometers way, MillimetersPerSecond speed) {
  return std::string(what) + " " + std::to_string(way.count() / 1'000'000) + " mm at " +
         std::to_string(static_cast<int>(speed.count() * 10)) + " mm/10 s";
}

struct Bench {
  explicit Bench(GpioAxisConfig given = axis_config()) : config(std::move(given)) {}

  void home() {
    homing.begin([this](HomingResult result) { results.push_back(result); });
  }
  // Ends the action that was begun.
  void over() { std::exchange(next, nullptr)(); }
  // Passes on the contact that has halted a pass.
  void contact(bool lasts = true, Duration at = 1s) {
    homing.contact({.active = lasts, .halted = true, .at = TimePoint{at}});
  }
  void to_fast_pass() {
    home();
    over();
  }
  void to_slow_pass() {
    to_fast_pass();
    contact();
    over();  // backed off
    over();  // settled
  }
  // Returns the calls since the last time.
  std::vector<std::string> done() { return std::exchange(did, {}); }

  Homing::Wiring wiring() {
    return {.forget_position = [this] { did.emplace_back("forget the position"); },
            .get_ready = [this](Homing::Call ready) { begins("get ready", std::move(ready)); },
            .switch_closed = [this] { return closed; },
            .run =
                [this](AxisDrive::RunKind kind, Nanometers distance, MillimetersPerSecond speed,
                       Homing::Call call) {
                  const char* const what = kind == AxisDrive::RunKind::Seek      ? "seek"
                                           : kind == AxisDrive::RunKind::BackOff ? "back off"
                                                                                 : "move";
                  run_over = call;
                  begins(millimeters_at(what, distance, speed), std::move(call));
                },
            .run_on = [this] { begins("run on", run_over); },
            .end_run = [this] { next = nullptr; },
            .turning = [this] { return turning; },
            .after =
                [this](Duration time, Homing::Call call) {
                  begins("wait " + std::to_string(time / 1ms) + " ms", std::move(call));
                },
            .take_position =
                [this](TimePoint edge) {
                  did.push_back("take the position at " + std::to_string(edge.time_since_epoch() / 1ms));
                },
            .know_position = [this] { did.emplace_back("know the position"); },
            .approach = [this](Homing::Call there) { begins("approach", std::move(there)); },
            .stop = [this] { did.emplace_back("stop"); },
            .forget =
                [this] {
                  next = nullptr;
                  ++forgotten;
                }};
  }
  void begins(const std::string& what, Homing::Call call) {
    did.push_back(what);
    next = std::move(call);
  }

  GpioAxisConfig config;
  bool closed = false, turning = false;
  Homing::Call next, run_over;
  int forgotten = 0;
  std::vector<std::string> did;
  std::vector<HomingResult> results;
  Homing homing{config, wiring()};
};

using Words = std::vector<std::string>;
using Results = std::vector<HomingResult>;

}  // namespace

TEST_CASE("Homing seeks fast, backs off, seeks slowly, takes the contact's time and goes to the switch") {
  Bench bench;
  bench.home();
  CHECK(bench.done() == Words{"forget the position", "get ready"});
  bench.over();
  CHECK(bench.done() == Words{"seek 105 mm at 50 mm/10 s"});
  bench.contact();
  CHECK(bench.done() == Words{"back off -5 mm at 50 mm/10 s"});
  bench.over();
  CHECK(bench.done() == Words{"wait 7 ms"});  // debouncing plus 2 ms until its result has arrived
  bench.over();
  CHECK(bench.done() == Words{"seek 10 mm at 25 mm/10 s"});
  bench.contact(true, 1'234ms);
  CHECK(bench.done() == Words{"take the position at 1234", "wait 0 ms"});
  bench.over();
  CHECK(bench.done() == Words{"know the position", "approach"});
  CHECK(bench.homing.under_way());
  CHECK(bench.results.empty());
  bench.over();
  CHECK(bench.results == Results{HomingResult::Homed});
  CHECK_FALSE(bench.homing.under_way());
  CHECK(bench.forgotten == 1);
}

TEST_CASE("With an encoder homing waits at the switch until the plate rests") {
  Bench bench(axis_config(true));
  bench.to_slow_pass();
  bench.done();
  bench.contact();
  CHECK(bench.done() == Words{"take the position at 1000", "wait 20 ms"});
}

TEST_CASE("Homing from a closed switch backs off first") {
  Bench bench;
  bench.closed = true;
  bench.to_fast_pass();
  CHECK(bench.done().back() == "back off -5 mm at 50 mm/10 s");
}

TEST_CASE("Homing ends if the switch is closed after backing off") {
  Bench bench;
  bench.to_fast_pass();
  bench.contact();
  bench.closed = true;
  bench.over();
  bench.over();
  CHECK(bench.results == Results{HomingResult::StillClosed});
}

TEST_CASE("The end of a pass ends homing if no contact has settled in time") {
  for (const bool slow : {false, true}) {
    CAPTURE(slow);
    Bench bench;
    if (slow) {
      bench.to_slow_pass();
    } else {
      bench.to_fast_pass();
    }
    bench.over();
    CHECK(bench.done().back() == "wait 7 ms");
    CHECK(bench.results.empty());
    bench.over();
    CHECK(bench.results == Results{HomingResult::NoTrigger});
  }
}

TEST_CASE("A switch that closes with the last step of a pass is detected") {
  Bench bench;
  bench.to_fast_pass();
  bench.over();
  bench.contact();
  CHECK(bench.done().back() == "back off -5 mm at 50 mm/10 s");
  CHECK(bench.results.empty());
}

TEST_CASE("A pass continues after any number of spikes, even at its very end") {
  Bench bench;
  bench.to_slow_pass();
  bench.done();
  for (int spikes = 0; spikes < 3; ++spikes) {
    bench.contact(false);
    CHECK(bench.done() == Words{"run on"});
  }
  bench.over();
  bench.contact(false);
  CHECK(bench.done() == Words{"wait 7 ms", "run on"});
  bench.contact();
  CHECK(bench.done().front() == "take the position at 1000");
}

TEST_CASE("A contact that settles while the motor turns is handled when it rests") {
  Bench bench;
  bench.to_slow_pass();
  bench.done();
  CHECK_FALSE(bench.homing.take_contact());
  bench.turning = true;
  bench.contact(true, 777ms);
  CHECK(bench.done().empty());
  bench.turning = false;
  CHECK(bench.homing.take_contact());
  CHECK(bench.done() == Words{"take the position at 777", "wait 0 ms"});
  CHECK_FALSE(bench.homing.take_contact());
}

TEST_CASE("A stop at any point of homing stops the motor and is answered when the motor rests") {
  for (int point = 0; point <= 8; ++point) {
    CAPTURE(point);
    Bench bench;
    bench.home();
    for (int i = 0; i < point; ++i) {
      // The contacts come instead of the end of the pass.
      if (i == 1 || i == 4) {
        bench.contact();
      } else if (i < 6) {
        bench.over();
      }
    }
    if (point > 6) bench.homing.stop();  // a second call
    bench.done();
    bench.homing.stop();
    CHECK(bench.done() == Words{"stop"});
    CHECK(bench.results.empty());
    bench.homing.stopped();
    CHECK(bench.results == Results{HomingResult::Stopped});
    CHECK_FALSE(bench.homing.under_way());
  }
}

TEST_CASE("After a stop in a pass, a contact or a spike ends homing as stopped and moves nothing") {
  for (const bool closed : {false, true}) {
    Bench bench;
    bench.to_slow_pass();
    bench.homing.stop();
    bench.done();
    CHECK(bench.homing.in_pass());
    bench.contact(closed);
    CHECK(bench.done().empty());
    CHECK(bench.results == Results{HomingResult::Stopped});
  }
}

TEST_CASE("Homing expects no contact outside its passes") {
  Bench bench;
  CHECK_FALSE(bench.homing.in_pass());
  bench.home();
  CHECK_FALSE(bench.homing.in_pass());
  bench.over();
  CHECK(bench.homing.in_pass());
  bench.contact();
  CHECK_FALSE(bench.homing.in_pass());
  bench.homing.stop();
  CHECK_FALSE(bench.homing.in_pass());
}

TEST_CASE("A fault becomes homing's answer, and later events of the pass move nothing") {
  Bench bench;
  bench.to_fast_pass();
  bench.done();
  bench.turning = true;
  bench.contact();
  bench.homing.failed(HomingResult::WrongSwitch);
  CHECK(bench.results == Results{HomingResult::WrongSwitch});
  bench.turning = false;
  CHECK_FALSE(bench.homing.take_contact());
  CHECK(bench.done().empty());
}

TEST_CASE("An abort drops homing's answer, and homing can begin again, also from within its answer") {
  Bench bench;
  bench.to_slow_pass();
  bench.homing.abort();
  CHECK_FALSE(bench.homing.under_way());
  bench.homing.failed(HomingResult::Fault);
  bench.homing.stopped();
  CHECK(bench.results.empty());
  bench.homing.begin([&bench](HomingResult) { bench.home(); });
  bench.homing.failed(HomingResult::Fault);
  CHECK(bench.homing.under_way());
  CHECK(bench.done().back() == "get ready");
}
