#include "hw/projector_with_light_line.hpp"

#include <optional>
#include <string>
#include <vector>

#include "hw/hardware_error.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

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
    lit = false;
  }
  bool lit = true;  // as it may be found
  bool broken = false;

 private:
  Log& log_;
};

class NotedProjector final : public Projector {
 public:
  explicit NotedProjector(Log& log) : log_(log) {}
  void power_on(Done done) override { note("power on"), done(reply); }
  void light_on(Done done) override { note("light on"), done(reply); }
  void light_off() noexcept override { note("light off"); }
  void power_off() noexcept override { note("power off"); }
  void ask_status(StatusDone done) override { done({reply, {}, true, 12}); }
  [[nodiscard]] std::string last_problem() const override { return "the projector's problem"; }
  ProjectorReply reply = ProjectorReply::Ok;

 private:
  void note(const char* what) { log_.emplace_back(what); }
  Log& log_;
};

}  // namespace

TEST_CASE(
    "a light line is off before the projector is told anything, and on only after the projector's light") {
  Log log;
  NotedLine line(log);
  NotedProjector inner(log);
  std::optional<ProjectorReply> reply;
  {
    ProjectorWithLightLine projector(inner, line);
    CHECK(log == Log{"line off"});
    projector.power_on([&](ProjectorReply r) { reply = r; });
    projector.light_on([&](ProjectorReply r) { reply = r; });
    CHECK(reply == ProjectorReply::Ok);
    CHECK(line.lit);
    projector.light_off();
    projector.light_on([&](ProjectorReply r) { reply = r; });
    projector.power_off();
    projector.light_on([&](ProjectorReply r) { reply = r; });
    projector.ask_status([](const ProjectorStatus& status) { CHECK(status.lamp_hours == 12); });
  }
  CHECK(log == Log{"line off", "line off", "power on", "light on", "line on", "line off", "light off",
                   "light on", "line on", "line off", "power off", "light on", "line on", "line off"});
}

TEST_CASE("a light line stays off when the projector does not turn its light on") {
  Log log;
  NotedLine line(log);
  NotedProjector inner(log);
  ProjectorWithLightLine projector(inner, line);
  inner.reply = ProjectorReply::NoAnswer;
  std::optional<ProjectorReply> reply;
  projector.light_on([&](ProjectorReply r) { reply = r; });
  CHECK(reply == ProjectorReply::NoAnswer);
  CHECK_FALSE(line.lit);
  CHECK(projector.last_problem() == "the projector's problem");
}

TEST_CASE("a light line that cannot be set turns the projector's light off again") {
  Log log;
  NotedLine line(log);
  NotedProjector inner(log);
  ProjectorWithLightLine projector(inner, line);
  line.broken = true;
  std::optional<ProjectorReply> reply;
  projector.light_on([&](ProjectorReply r) { reply = r; });
  CHECK(reply == ProjectorReply::Refused);
  CHECK(projector.last_problem() == "line 26 of gpiochip0 cannot be set");
  CHECK(log.back() == "light off");
}

TEST_CASE("a light engine that is only a line warms up by time, once, and is dark at its end") {
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
    projector.light_on([&](ProjectorReply r) { reply = r; });
    CHECK(line.lit);
    CHECK(wait() == ProjectorReply::Ok);
    projector.light_off();
    CHECK_FALSE(line.lit);
    line.broken = true;
    projector.light_on([&](ProjectorReply r) { reply = r; });
    CHECK(wait() == ProjectorReply::Refused);
    CHECK(projector.last_problem() == "line 26 of gpiochip0 cannot be set");
    line.broken = false;
    projector.light_on([&](ProjectorReply r) { reply = r; });
    projector.light_off();
    CHECK_FALSE(wait());  // dropped
    projector.light_on([&](ProjectorReply r) { reply = r; });
  }
  CHECK_FALSE(line.lit);
}
