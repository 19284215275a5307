#include "hw/projector_with_light_line.hpp"

#include <optional>
#include <string>
#include <vector>

#include "hw/hardware_error.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/hw/plain_devices.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

using Log = std::vector<std::string>;

class NotedLine final : public LightLine {
 public:
  explicit NotedLine(Log& log) : log_(log) {}
  void on() override {
    if (broken) throw HardwareError("line 26 of gpiochip0 cannot be set");
    log_.emplace_back("line on");
    lit = true;
  }
  void off() noexcept override {
    log_.emplace_back("line off");
    if (!stuck) lit = false;
  }
  [[nodiscard]] std::string refusal() const override {
    return stuck && lit ? "the light's line is stuck" : "";
  }
  [[nodiscard]] std::optional<TimePoint> cut_at() const override { return cut; }
  [[nodiscard]] std::optional<TimePoint> cut_by() const override { return cut; }
  bool stuck = false;
  bool lit = true;  // a line may be found on
  std::optional<TimePoint> cut;
  bool broken = false;

 private:
  Log& log_;
};

class NotedProjector final : public testing::PlainProjector {
 public:
  explicit NotedProjector(Log& log) : log_(log) {}
  void power_on(Done done) override { note("power on"), done(reply); }
  void light_on(Duration, LightOn tell) override { note("light on"), tell.done(reply); }
  void light_off() noexcept override { note("light off"); }
  void when_dark(std::function<void()> call) override { dark = std::move(call); }
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return std::nullopt; }
  void power_off() noexcept override { note("power off"); }
  void ask_status(StatusDone done) override { done({reply, {}, true, 12}); }
  [[nodiscard]] std::string last_problem() const override { return "the projector's problem"; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return unconfirmed; }
  void may_warm_up() override { note("may warm up"); }
  void confirm_dark(Done done) override { note("confirm dark"), done(reply); }
  void power_off_if_on() override { note("power off if on"); }
  [[nodiscard]] bool lost() const override { return true; }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override { return {"why"}; }
  [[nodiscard]] std::string description() const override { return "the projector"; }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {"hot"}; }
  [[nodiscard]] LightSerialPath light_off_path() const override { return {7, "off", {}}; }
  ProjectorReply reply = ProjectorReply::Ok;
  std::string unconfirmed;
  std::function<void()> dark;

 private:
  void note(const char* what) { log_.emplace_back(what); }
  Log& log_;
};

struct Bench {
  Log log;
  VirtualClock clock;
  NotedLine line{log};
  NotedProjector inner{log};
  ProjectorWithLightLine projector{inner, line, clock};
  std::optional<ProjectorReply> reply;
  std::optional<TimePoint> sent;
  bool dark = false;

  void run_out() {
    while (clock.run_next()) {
    }
  }
  void light_on() {
    reply.reset(), sent.reset();
    projector.light_on(1s, {.sent = [this](TimePoint earliest) { sent = earliest; },
                            .done = [this](ProjectorReply r) { reply = r; }});
    run_out();
  }
  void wait_for_dark() {
    dark = false;
    projector.when_dark([this] { dark = true; });
  }
};

}  // namespace

TEST_CASE(
    "a light line is off before the projector gets any command, and on only after the projector's light") {
  Log log;
  {
    Bench bench;
    CHECK(bench.log == Log{"line off"});
    bench.projector.power_on([&](ProjectorReply r) { bench.reply = r; });
    bench.run_out();
    CHECK(bench.reply == ProjectorReply::Ok);
    bench.light_on();
    CHECK(bench.reply == ProjectorReply::Ok);
    CHECK(bench.sent == bench.clock.now());
    CHECK(bench.line.lit);
    bench.projector.light_off();
    bench.light_on();
    bench.projector.power_off();
    bench.light_on();
    bench.projector.ask_status([](const ProjectorStatus& status) { CHECK(status.lamp_hours == 12); });
    log = bench.log;
  }
  CHECK(log == Log{"line off", "line off", "power on", "light on", "line on", "line off", "light off",
                   "light on", "line on", "line off", "power off", "light on", "line on"});
}

TEST_CASE("a light line stays off when the projector does not turn its light on") {
  Bench bench;
  bench.inner.reply = ProjectorReply::NoAnswer;
  bench.light_on();
  CHECK(bench.reply == ProjectorReply::NoAnswer);
  CHECK_FALSE(bench.line.lit);
  CHECK_FALSE(bench.sent);
  CHECK_FALSE(bench.projector.last_light());
  CHECK(bench.projector.last_problem() == "the projector's problem");
}

TEST_CASE("a light line that cannot be set turns the projector's light off again") {
  Bench bench;
  bench.line.broken = true;
  bench.light_on();
  CHECK(bench.reply == ProjectorReply::Refused);
  CHECK(bench.projector.last_problem() == "line 26 of gpiochip0 cannot be set");
  CHECK(bench.log.back() == "light off");
}

TEST_CASE("a light with a light line shone from the line's on to its off") {
  Bench bench;
  bench.light_on();
  const auto later = bench.clock.call_after(3s, [] {});
  bench.run_out();
  bench.projector.light_off();
  const auto light = bench.projector.last_light();
  REQUIRE(light);
  CHECK(light->least() == 3s);
  CHECK(light->most(bench.clock.now()) == 3s);
  bench.inner.reply = ProjectorReply::NoAnswer;
  bench.light_on();
  CHECK_FALSE(bench.projector.last_light());  // not the previous light's
}

TEST_CASE("a light that its line has cut counts as off from then on, even before it is turned off") {
  Bench bench;
  bench.light_on();
  CHECK_FALSE(bench.projector.last_light()->off_earliest);
  bench.line.cut = bench.clock.now() + 700ms;
  const auto later = bench.clock.call_after(1s, [] {});
  bench.run_out();
  CHECK(bench.projector.last_light()->off_earliest == bench.line.cut);
  CHECK(bench.projector.last_light()->least() == 700ms);
  bench.projector.light_off();
  CHECK(bench.projector.last_light()->least() == 700ms);
  CHECK(bench.projector.last_light()->most(bench.clock.now()) == 700ms);
}

TEST_CASE("a light with a light line is dark when both the projector and the line are") {
  Bench bench;
  bench.light_on();
  bench.line.stuck = true;
  bench.projector.light_off();
  bench.wait_for_dark();
  for (int i = 0; i < 10; ++i)
    bench.clock.run_next();
  CHECK_FALSE(bench.dark);  // neither has confirmed
  bench.inner.dark();
  for (int i = 0; i < 10; ++i)
    bench.clock.run_next();
  CHECK_FALSE(bench.dark);
  CHECK(bench.projector.light_off_unconfirmed() == "the light's line is stuck");
  CHECK_FALSE(bench.projector.last_light()->off_latest);
  bench.line.lit = false;
  bench.run_out();
  CHECK(bench.dark);
  CHECK(bench.projector.last_light()->off_latest);
  CHECK(bench.projector.light_off_unconfirmed().empty());
  bench.inner.unconfirmed = "not confirmed";
  CHECK(bench.projector.light_off_unconfirmed() == "not confirmed");
}

TEST_CASE("a projector does not call back after its light line was taken away") {
  Log log;
  VirtualClock clock;
  NotedProjector inner(log);
  NotedLine line(log);
  {
    ProjectorWithLightLine projector(inner, line, clock);
    projector.when_dark([] {});
    REQUIRE(inner.dark);
  }
  CHECK_FALSE(inner.dark);
}

TEST_CASE("power on is refused while the light line cannot be turned off") {
  Bench bench;
  bench.line.stuck = true;
  bench.line.lit = true;
  bench.projector.power_on([&](ProjectorReply r) { bench.reply = r; });
  bench.run_out();
  CHECK(bench.reply == ProjectorReply::Refused);
  CHECK(bench.projector.last_problem() == "the light's line is stuck");
}

TEST_CASE("a light engine that is only a line warms up by time, once, and is dark after its destruction") {
  Log log;
  VirtualClock clock;
  NotedLine line(log);
  std::optional<ProjectorReply> reply;
  const auto wait = [&] {
    while (!reply && clock.run_next()) {
    }
    return std::exchange(reply, std::nullopt);
  };
  {
    LightLineProjector projector(line, clock, 3s);
    CHECK_FALSE(line.lit);
    projector.power_on([&](ProjectorReply r) { reply = r; });
    CHECK(wait() == ProjectorReply::Ok);
    CHECK(clock.now().time_since_epoch() == 3s);
    projector.power_on([&](ProjectorReply r) { reply = r; });
    CHECK(wait() == ProjectorReply::Ok);
    CHECK(clock.now().time_since_epoch() == 3s);
    projector.light_on(1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
    CHECK(line.lit);
    CHECK(wait() == ProjectorReply::Ok);
    projector.light_off();
    CHECK_FALSE(line.lit);
    line.broken = true;
    projector.light_on(1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
    CHECK(wait() == ProjectorReply::Refused);
    CHECK(projector.last_problem() == "line 26 of gpiochip0 cannot be set");
    line.broken = false;
    projector.light_on(1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
    projector.light_off();
    CHECK_FALSE(wait());  // dropped
    projector.light_on(1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
  }
  CHECK_FALSE(line.lit);
}

TEST_CASE("a projector with a light line passes the other calls on to the projector") {
  Bench bench;
  bench.log.clear();
  bench.projector.may_warm_up();
  bench.projector.power_off_if_on();
  CHECK(bench.log == Log{"may warm up", "power off if on"});
  CHECK(bench.projector.lost());
  CHECK(bench.projector.description() == "the projector");
  CHECK(bench.projector.warnings() == Log{"hot"});
  CHECK(bench.projector.light_off_path().descriptor == 7);
  CHECK(bench.projector.why_not_ready() == Log{"why"});
}

TEST_CASE("a projector with a light line is confirmed dark when both are") {
  for (const bool stuck : {false, true}) {
    for (const ProjectorReply inner : {ProjectorReply::Ok, ProjectorReply::NoAnswer}) {
      CAPTURE(stuck, inner);
      Bench bench;
      bench.line.lit = bench.line.stuck = stuck;
      bench.inner.reply = inner;
      std::optional<ProjectorReply> reply;
      bench.log.clear();
      bench.projector.confirm_dark([&](ProjectorReply r) { reply = r; });
      while (bench.clock.run_next()) {
      }
      CHECK(bench.log == Log{"line off", "confirm dark"});
      const ProjectorReply line = stuck ? ProjectorReply::Refused : ProjectorReply::Ok;
      CHECK(reply == (inner == ProjectorReply::Ok ? line : inner));
      CHECK(bench.projector.why_not_ready().size() == (stuck ? 2 : 1));
    }
  }
}
