// Tests of Homing alone: the test records its calls to the axis and sets the motor's state.
#include "hw/gpio/homing.hpp"

#include "tests/catch.hpp"

namespace {

// 5 ms of debouncing, 100 mm of travel, 5 mm/s.
GpioAxisConfig homing_config(bool encoder = false) {
  GpioAxisConfig config;
  config.travel = Nanometers{100'000'000};
  if (encoder) config.encoder = EncoderConfig{};
  return config;
}

std::string millimeters_at(const char* what, Nanometers way, MillimetersPerSecond speed) {
  return std::string(what) + " " + std::to_string(way.count() / 1'000'000) + " mm at " +
         std::to_string(static_cast<int>(speed.count() * 10)) + " mm/10 s";
}

struct HomingFixture {
  explicit HomingFixture(GpioAxisConfig given = homing_config()) : config(std::move(given)) {}

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

TEST_CASE_METHOD(
    HomingFixture,
    "Homing seeks fast, backs off, seeks slowly, takes the contact's time and goes to the switch") {
  home();
  CHECK(done() == Words{"forget the position", "get ready"});
  over();
  CHECK(done() == Words{"seek 105 mm at 50 mm/10 s"});
  contact();
  CHECK(done() == Words{"back off -5 mm at 50 mm/10 s"});
  over();
  CHECK(done() == Words{"wait 7 ms"});  // debouncing plus 2 ms until its result has arrived
  over();
  CHECK(done() == Words{"seek 10 mm at 25 mm/10 s"});
  contact(true, 1'234ms);
  CHECK(done() == Words{"take the position at 1234", "wait 0 ms"});
  over();
  CHECK(done() == Words{"know the position", "approach"});
  CHECK(homing.under_way());
  CHECK(results.empty());
  over();
  CHECK(results == Results{HomingResult::Homed});
  CHECK_FALSE(homing.under_way());
  CHECK(forgotten == 1);
}

TEST_CASE("With an encoder homing waits at the switch until the plate rests") {
  HomingFixture fixture(homing_config(true));
  fixture.to_slow_pass();
  fixture.done();
  fixture.contact();
  CHECK(fixture.done() == Words{"take the position at 1000", "wait 20 ms"});
}

TEST_CASE_METHOD(HomingFixture, "Homing from a closed switch backs off first") {
  closed = true;
  to_fast_pass();
  CHECK(done().back() == "back off -5 mm at 50 mm/10 s");
}

TEST_CASE_METHOD(HomingFixture, "Homing ends if the switch is closed after backing off") {
  to_fast_pass();
  contact();
  closed = true;
  over();
  over();
  CHECK(results == Results{HomingResult::StillClosed});
}

TEST_CASE("The end of a pass ends homing if no contact has settled in time") {
  for (const bool slow : {false, true}) {
    CAPTURE(slow);
    HomingFixture fixture;
    if (slow) {
      fixture.to_slow_pass();
    } else {
      fixture.to_fast_pass();
    }
    fixture.over();
    CHECK(fixture.done().back() == "wait 7 ms");
    CHECK(fixture.results.empty());
    fixture.over();
    CHECK(fixture.results == Results{HomingResult::NoTrigger});
  }
}

TEST_CASE_METHOD(HomingFixture, "A switch that closes with the last step of a pass is detected") {
  to_fast_pass();
  over();
  contact();
  CHECK(done().back() == "back off -5 mm at 50 mm/10 s");
  CHECK(results.empty());
}

TEST_CASE_METHOD(HomingFixture, "A pass continues after any number of spikes, even at its very end") {
  to_slow_pass();
  done();
  for (int spikes = 0; spikes < 3; ++spikes) {
    contact(false);
    CHECK(done() == Words{"run on"});
  }
  over();
  contact(false);
  CHECK(done() == Words{"wait 7 ms", "run on"});
  contact();
  CHECK(done().front() == "take the position at 1000");
}

TEST_CASE_METHOD(HomingFixture, "A contact that settles while the motor turns is handled when it rests") {
  to_slow_pass();
  done();
  CHECK_FALSE(homing.take_contact());
  turning = true;
  contact(true, 777ms);
  CHECK(done().empty());
  turning = false;
  CHECK(homing.take_contact());
  CHECK(done() == Words{"take the position at 777", "wait 0 ms"});
  CHECK_FALSE(homing.take_contact());
}

TEST_CASE("A stop at any point of homing stops the motor and is answered when the motor rests") {
  for (int point = 0; point <= 8; ++point) {
    CAPTURE(point);
    HomingFixture fixture;
    fixture.home();
    for (int i = 0; i < point; ++i) {
      // The contacts come instead of the end of the pass.
      if (i == 1 || i == 4) {
        fixture.contact();
      } else if (i < 6) {
        fixture.over();
      }
    }
    if (point > 6) fixture.homing.stop();  // a second call
    fixture.done();
    fixture.homing.stop();
    CHECK(fixture.done() == Words{"stop"});
    CHECK(fixture.results.empty());
    fixture.homing.stopped();
    CHECK(fixture.results == Results{HomingResult::Stopped});
    CHECK_FALSE(fixture.homing.under_way());
  }
}

TEST_CASE("After a stop in a pass, a contact or a spike ends homing as stopped and moves nothing") {
  for (const bool closed : {false, true}) {
    HomingFixture fixture;
    fixture.to_slow_pass();
    fixture.homing.stop();
    fixture.done();
    CHECK(fixture.homing.in_pass());
    fixture.contact(closed);
    CHECK(fixture.done().empty());
    CHECK(fixture.results == Results{HomingResult::Stopped});
  }
}

TEST_CASE_METHOD(HomingFixture, "Homing expects no contact outside its passes") {
  CHECK_FALSE(homing.in_pass());
  home();
  CHECK_FALSE(homing.in_pass());
  over();
  CHECK(homing.in_pass());
  contact();
  CHECK_FALSE(homing.in_pass());
  homing.stop();
  CHECK_FALSE(homing.in_pass());
}

TEST_CASE_METHOD(HomingFixture,
                 "A fault becomes homing's answer, and later events of the pass move nothing") {
  to_fast_pass();
  done();
  turning = true;
  contact();
  homing.failed(HomingResult::WrongSwitch);
  CHECK(results == Results{HomingResult::WrongSwitch});
  turning = false;
  CHECK_FALSE(homing.take_contact());
  CHECK(done().empty());
}

TEST_CASE_METHOD(HomingFixture,
                 "An abort drops homing's answer, and homing can begin again, also from within its answer") {
  to_slow_pass();
  homing.abort();
  CHECK_FALSE(homing.under_way());
  homing.failed(HomingResult::Fault);
  homing.stopped();
  CHECK(results.empty());
  homing.begin([this](HomingResult) { home(); });
  homing.failed(HomingResult::Fault);
  CHECK(homing.under_way());
  CHECK(done().back() == "get ready");
}
