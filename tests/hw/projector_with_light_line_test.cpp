#include "hw/projector_with_light_line.hpp"

#include "hw/hardware_error.hpp"
#include "hw/simulated_printer.hpp"
#include "tests/catch.hpp"
#include "tests/hw/noted_projector.hpp"
#include "tests/hw/virtual_time_fixture.hpp"

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

struct ProjectorWithLineFixture : testing::VirtualTimeFixture {
  Log log;
  NotedLine line{log};
  testing::NotedProjector inner{log};
  ProjectorWithLightLine projector{inner, line, clock};
  std::optional<ProjectorReply> reply;
  std::optional<TimePoint> sent;
  bool dark = false;

  void light_on() {
    reply.reset(), sent.reset();
    projector.light_on(1s, {.sent = [this](TimePoint earliest) { sent = earliest; },
                            .done = [this](ProjectorReply r) { reply = r; }});
    run();
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
    ProjectorWithLineFixture fixture;
    CHECK(fixture.log == Log{"line off"});
    fixture.projector.power_on([&](ProjectorReply r) { fixture.reply = r; });
    fixture.run();
    CHECK(fixture.reply == ProjectorReply::Ok);
    fixture.light_on();
    CHECK(fixture.reply == ProjectorReply::Ok);
    CHECK(fixture.sent == fixture.clock.now());
    CHECK(fixture.line.lit);
    fixture.projector.light_off();
    fixture.light_on();
    fixture.projector.power_off();
    fixture.light_on();
    fixture.projector.ask_status([](const ProjectorStatus& status) { CHECK(status.lamp_hours == 12); });
    log = fixture.log;
  }
  CHECK(log == Log{"line off", "line off", "power on", "light on", "line on", "line off", "light off",
                   "light on", "line on", "line off", "power off", "light on", "line on"});
}

TEST_CASE_METHOD(ProjectorWithLineFixture,
                 "a light line stays off when the projector does not turn its light on") {
  inner.reply = ProjectorReply::NoAnswer;
  light_on();
  CHECK(reply == ProjectorReply::NoAnswer);
  CHECK_FALSE(line.lit);
  CHECK_FALSE(sent);
  CHECK_FALSE(projector.last_light());
  CHECK(projector.last_problem() == "the projector's problem");
}

TEST_CASE_METHOD(ProjectorWithLineFixture,
                 "a light line that cannot be set turns the projector's light off again") {
  line.broken = true;
  light_on();
  CHECK(reply == ProjectorReply::Refused);
  CHECK(projector.last_problem() == "line 26 of gpiochip0 cannot be set");
  CHECK(log.back() == "light off");
}

TEST_CASE_METHOD(ProjectorWithLineFixture, "a light with a light line shone from the line's on to its off") {
  light_on();
  const auto later = clock.call_after(3s, [] {});
  run();
  projector.light_off();
  const auto light = projector.last_light();
  REQUIRE(light);
  CHECK(light->least() == 3s);
  CHECK(light->most(clock.now()) == 3s);
  inner.reply = ProjectorReply::NoAnswer;
  light_on();
  CHECK_FALSE(projector.last_light());  // not the previous light's
}

TEST_CASE_METHOD(ProjectorWithLineFixture,
                 "a light that its line has cut counts as off from then on, even before it is turned off") {
  light_on();
  CHECK_FALSE(projector.last_light()->off_earliest);
  line.cut = clock.now() + 700ms;
  const auto later = clock.call_after(1s, [] {});
  run();
  CHECK(projector.last_light()->off_earliest == line.cut);
  CHECK(projector.last_light()->least() == 700ms);
  projector.light_off();
  CHECK(projector.last_light()->least() == 700ms);
  CHECK(projector.last_light()->most(clock.now()) == 700ms);
}

TEST_CASE_METHOD(ProjectorWithLineFixture,
                 "a light with a light line is dark when both the projector and the line are") {
  light_on();
  line.stuck = true;
  projector.light_off();
  wait_for_dark();
  for (int i = 0; i < 10; ++i)
    clock.run_next();
  CHECK_FALSE(dark);  // neither has confirmed
  inner.dark();
  for (int i = 0; i < 10; ++i)
    clock.run_next();
  CHECK_FALSE(dark);
  CHECK(projector.light_off_unconfirmed() == "the light's line is stuck");
  CHECK_FALSE(projector.last_light()->off_latest);
  line.lit = false;
  run();
  CHECK(dark);
  CHECK(projector.last_light()->off_latest);
  CHECK(projector.light_off_unconfirmed().empty());
  inner.unconfirmed = "not confirmed";
  CHECK(projector.light_off_unconfirmed() == "not confirmed");
}

TEST_CASE("a projector does not call back after its light line was taken away") {
  Log log;
  VirtualClock clock;
  testing::NotedProjector inner(log);
  NotedLine line(log);
  {
    ProjectorWithLightLine projector(inner, line, clock);
    projector.when_dark([] {});
    REQUIRE(inner.dark);
  }
  CHECK_FALSE(inner.dark);
}

TEST_CASE_METHOD(ProjectorWithLineFixture, "power on is refused while the light line cannot be turned off") {
  line.stuck = true;
  line.lit = true;
  projector.power_on([&](ProjectorReply r) { reply = r; });
  run();
  CHECK(reply == ProjectorReply::Refused);
  CHECK(projector.last_problem() == "the light's line is stuck");
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

TEST_CASE_METHOD(ProjectorWithLineFixture,
                 "a projector with a light line passes the other calls on to the projector") {
  log.clear();
  projector.may_warm_up();
  projector.power_off_if_on();
  CHECK(log == Log{"may warm up", "power off if on"});
  CHECK(projector.lost());
  CHECK(projector.description() == "the projector");
  CHECK(projector.warnings() == Log{"hot"});
  CHECK(projector.light_off_path().descriptor == 7);
  CHECK(projector.why_not_ready() == Log{"why"});
}

TEST_CASE("a projector with a light line is confirmed dark when both are") {
  for (const bool stuck : {false, true}) {
    for (const ProjectorReply inner : {ProjectorReply::Ok, ProjectorReply::NoAnswer}) {
      CAPTURE(stuck, inner);
      ProjectorWithLineFixture fixture;
      fixture.line.lit = fixture.line.stuck = stuck;
      fixture.inner.reply = inner;
      std::optional<ProjectorReply> reply;
      fixture.log.clear();
      fixture.projector.confirm_dark([&](ProjectorReply r) { reply = r; });
      fixture.run();
      CHECK(fixture.log == Log{"line off", "confirm dark"});
      const ProjectorReply line = stuck ? ProjectorReply::Refused : ProjectorReply::Ok;
      CHECK(reply == (inner == ProjectorReply::Ok ? line : inner));
      CHECK(fixture.projector.why_not_ready().size() == (stuck ? 2 : 1));
    }
  }
}
