#include "hw/real_machine.hpp"

#include "hw/hardware_check.hpp"
#include "hw/hardware_error.hpp"
#include "hw/light_off.hpp"
#include "hw/serial/serial_projector.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/no_descriptors.hpp"
#include "tests/hw/serial/scripted_channel.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

namespace {

// Returns a configuration of devices that no computer has.
RealMachineConfig nowhere() {
  RealMachineConfig config;
  for (GpioLineConfig* line : {&config.axis.step, &config.axis.direction, &config.axis.limit_switch.line})
    line->chip = "gpiochip-missing";
  config.axis.step.line = "17";
  config.axis.direction.line = "27";
  config.axis.limit_switch.line.line = "23";
  config.display.card = "/dev/dri/card-missing";
  config.light = GpioLineConfig{.chip = "gpiochip-missing", .line = "24"};
  config.projector = SerialProjectorConfig{.port = "/dev/tty-missing", .table = {}, .brightness = {}};
  return config;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++found;
  return found;
}

}  // namespace

TEST_CASE_METHOD(testing::ReadyWatchdogFixture,
                 "A machine whose devices are all missing starts, says what is missing, and does nothing") {
  RealMachine machine(clock, watcher, watchdog, nowhere());
  const std::string not_ready = machine.why_not_ready();
  CHECK(count(not_ready, "gpiochip-missing") >= 2);  // for the light, and for the axis
  CHECK(count(not_ready, "/dev/dri/card-missing") >= 1);
  CHECK(count(not_ready, "/dev/tty-missing") >= 1);
  CHECK(machine.description().empty());
  make_safe(machine);
  CHECK_FALSE(machine.z_axis().height());
  CHECK(machine.z_axis().travel() == GpioAxisConfig{}.travel);
  CHECK(machine.display().width() == Pixels{1920});

  // Each device answers, from the clock, with a failure.
  std::optional<HomingResult> homed;
  std::optional<MoveResult> moved;
  std::optional<ProjectorReply> lit;
  bool shown = true;
  machine.z_axis().home([&](HomingResult result) { homed = result; });
  machine.projector().light_on(std::chrono::seconds{1}, {.sent = [](TimePoint) {},
                                                         .done = [&](ProjectorReply reply) { lit = reply; }});
  testing::watch_over_exposure(watchdog, process);
  machine.display().black([&](std::optional<TimePoint> at) { shown = at.has_value(); });
  CHECK_FALSE(homed);
  CHECK_FALSE(lit);
  CHECK(shown);
  for (int i = 0; i < 3; ++i)
    REQUIRE(clock.run_next());
  CHECK(homed == HomingResult::Fault);
  CHECK(lit == ProjectorReply::Refused);
  CHECK_FALSE(shown);
  machine.z_axis().move_to(Nanometers{1}, MillimetersPerSecond{1},
                           [&](MoveResult result) { moved = result; });
  REQUIRE(clock.run_next());
  CHECK(moved == MoveResult::NotHomed);
}

TEST_CASE_METHOD(
    testing::ReadyWatchdogFixture,
    "Missing devices are searched for again and again, and those that are still missing are not reported") {
  RealMachine machine(clock, watcher, watchdog, nowhere());
  int reported = 0;
  machine.on_event([&](const MachineEvent&) { ++reported; });
  for (int i = 1; i <= 3; ++i) {
    REQUIRE(clock.run_next());
    CHECK(clock.now() == TimePoint{} + i * RealMachine::kSearchInterval);
  }
  CHECK(reported == 0);
  CHECK_FALSE(machine.why_not_ready().empty());
}

namespace {

// A machine of nothing but an axis, which a test can make missing.
struct AxisMachineFixture {
  AxisMachineFixture() {
    config.light.reset();
    config.projector.reset();
  }
  void start() {
    machine = std::make_unique<RealMachine>(plant.clock, plant, watchdog, config,
                                            RealMachine::Openers{.axis = [this] { return open_axis(); }});
    machine->on_event([this](const MachineEvent& event) { reported.push_back(event); });
  }
  std::unique_ptr<GpioAxis> open_axis() {
    ++opened;
    if (missing) throw HardwareError("the axis is missing");
    plant.build();
    return std::move(plant.axis);
  }

  RealMachineConfig config = nowhere();
  testing::Plant plant{GpioAxisConfig{}};
  bool missing = false;
  int opened = 0;
  std::vector<MachineEvent> reported;
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(plant.clock, plant, process);
  std::unique_ptr<RealMachine> machine;
};

}  // namespace

TEST_CASE_METHOD(AxisMachineFixture,
                 "An axis whose chip is unplugged prevents printing from then on, and is searched for") {
  start();
  CHECK(count(machine->why_not_ready(), "axis") == 0);
  missing = true;
  plant.pull_chip();
  REQUIRE(reported.size() == 1);
  CHECK(reported[0].kind == MachineEvent::Kind::Fault);
  CHECK(count(machine->why_not_ready(), "the axis' inputs on") == 1);
  CHECK(opened == 1);
  plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(opened >= 2);
  CHECK(count(machine->why_not_ready(), "the axis is missing") == 1);
  CHECK(reported.size() == 1);
}

TEST_CASE_METHOD(AxisMachineFixture, "An axis whose lines the kernel refuses to set counts as lost") {
  start();
  plant.step->refuses = true;
  std::optional<HomingResult> homed;
  machine->z_axis().home([&](HomingResult result) { homed = result; });
  plant.run([&] { return homed.has_value(); });
  CHECK(homed == HomingResult::Fault);
  CHECK(count(machine->why_not_ready(), "line") >= 1);
  missing = true;
  plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(opened >= 2);
}

TEST_CASE_METHOD(AxisMachineFixture,
                 "The warnings of a device that comes late are reported when it is found") {
  missing = true;
  plant.refusals = {"no real-time priority"};
  start();
  missing = false;
  plant.run_for(2 * RealMachine::kSearchInterval);
  REQUIRE(reported.size() == 1);
  CHECK(reported[0].kind == MachineEvent::Kind::Recovery);
  CHECK(reported[0].warnings == std::vector<std::string>{"no real-time priority"});
}

namespace {

// Returns a projector whose table has only power commands, which it does not answer.
SerialProjectorConfig silent_projector() {
  SerialProjectorConfig config{.port = "/dev/ttyUSB7", .table = {}, .brightness = {}};
  config.table.power_on = {"power on", "on\r", std::chrono::seconds{1}, {}};
  config.table.power_off = {"power off", "off\r", std::chrono::seconds{1}, {}};
  return config;
}

// A machine whose light is a line that may break.
struct LightMachineFixture {
  explicit LightMachineFixture(bool without_light = false, bool without_axis = false,
                               std::optional<SerialProjectorConfig> projector = std::nullopt)
      : chip_gone(without_light), axis_missing(without_axis) {
    plant.config.lid = GpioInputConfig{.line = {.chip = "gpiochip0", .line = "5"}};
    config.light = GpioLineConfig{.chip = "gpiochip7", .line = "24"};
    config.projector = std::move(projector);
    machine =
        std::make_unique<RealMachine>(plant.clock, plant, watchdog, config,
                                      RealMachine::Openers{.axis = [this] { return open_axis(); },
                                                           .light = [this] { return open_light(); },
                                                           .projector = [this] { return open_projector(); }});
    machine->on_event([this](const MachineEvent& event) { reported.push_back(event); });
  }
  std::unique_ptr<GpioAxis> open_axis() {
    if (axis_missing) throw HardwareError("the axis is missing");
    plant.build();
    return std::move(plant.axis);
  }
  std::unique_ptr<Projector> open_projector() {
    return std::make_unique<SerialProjector>(std::make_unique<testing::ScriptedChannel>(plant.clock),
                                             plant.clock,
                                             std::get<SerialProjectorConfig>(*config.projector).table);
  }
  std::unique_ptr<GpioLightLine> open_light() {
    ++opened;
    if (chip_gone) throw HardwareError("there is no GPIO chip \"gpiochip7\"");
    auto output = std::make_unique<testing::PlantOutput>();
    line = output.get();
    return std::make_unique<GpioLightLine>(std::move(output), "line 24 of gpiochip7", plant.clock);
  }
  std::optional<ProjectorReply> light_on() {
    std::optional<ProjectorReply> reply;
    machine->projector().light_on(std::chrono::seconds{1},
                                  {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
    answer();
    plant.run([&] { return reply.has_value(); });
    return reply;
  }
  void power_on() {
    std::optional<ProjectorReply> reply;
    machine->projector().power_on([&](ProjectorReply r) { reply = r; });
    plant.run([&] { return reply.has_value(); });
    REQUIRE(reply == ProjectorReply::Ok);
  }
  void move_lid(bool open) {
    plant.press(AxisInput::Lid, open);
    plant.run_for(std::chrono::milliseconds{100});
  }
  // Answers as a live light watchdog would.
  void answer() {
    testing::watch_over_exposure(watchdog, process);
    answer_again = plant.clock.call_after(LightWatchdog::kHeartbeat, [this] { answer(); });
  }

  RealMachineConfig config = nowhere();
  testing::Plant plant{GpioAxisConfig{}};
  testing::PlantOutput* line = nullptr;
  bool chip_gone, axis_missing;
  int opened = 0;
  std::vector<MachineEvent> reported;
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(plant.clock, plant, process);
  std::unique_ptr<Timer> answer_again;
  std::unique_ptr<RealMachine> machine;
};

// A time by which missing devices have been searched for, and at which no search is due.
constexpr Duration kPastSearch = RealMachine::kSearchInterval + std::chrono::seconds{1};

}  // namespace

TEST_CASE_METHOD(
    LightMachineFixture,
    "A light line that refuses to go off prevents printing, and its chip is opened again when it is back") {
  CHECK(light_on() == ProjectorReply::Ok);
  REQUIRE(line->level);
  line->refuses = chip_gone = true;
  machine->projector().light_off();
  CHECK_FALSE(machine->projector().light_off_unconfirmed().empty());
  plant.run_for(std::chrono::milliseconds{100});
  REQUIRE(reported.size() == 1);
  CHECK(reported[0].kind == MachineEvent::Kind::Fault);
  CHECK(count(machine->why_not_ready(), "the light may be on: the light's line 24 of gpiochip7") == 1);
  plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(opened >= 2);
  CHECK(count(machine->why_not_ready(), "the light may be on: the light's line 24 of gpiochip7") == 1);
  CHECK(count(machine->why_not_ready(), "there is no GPIO chip") == 1);
  CHECK_FALSE(machine->projector().light_off_unconfirmed().empty());
  chip_gone = false;
  plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(count(machine->why_not_ready(), "light") == 0);
  CHECK(machine->projector().light_off_unconfirmed().empty());
  REQUIRE(reported.size() == 2);
  CHECK(reported[1].kind == MachineEvent::Kind::Recovery);
  CHECK(reported[1].what == "found light: line 24 of gpiochip7");
}

TEST_CASE("A projector does not count as dark while its light line, which refused to go off, is gone") {
  LightMachineFixture fixture(false, false, silent_projector());
  fixture.power_on();
  REQUIRE(fixture.light_on() == ProjectorReply::Ok);
  REQUIRE(fixture.line->level);
  fixture.line->refuses = fixture.chip_gone = true;
  bool dark = false;
  fixture.machine->projector().light_off();
  fixture.machine->projector().when_dark([&dark] { dark = true; });
  fixture.plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(fixture.opened >= 2);
  CHECK(count(fixture.machine->projector().light_off_unconfirmed(), "line 24 of gpiochip7 cannot be set") ==
        1);
  CHECK_FALSE(dark);
  fixture.machine->projector().light_off();
  fixture.machine->projector().when_dark([&dark] { dark = true; });
  fixture.plant.run_for(std::chrono::seconds{1});
  CHECK_FALSE(dark);
  fixture.chip_gone = false;
  fixture.plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(dark);
  CHECK(fixture.machine->projector().light_off_unconfirmed().empty());
}

TEST_CASE_METHOD(LightMachineFixture, "A light line that goes off after all no longer prevents printing") {
  CHECK(light_on() == ProjectorReply::Ok);
  line->refuses = chip_gone = true;
  machine->projector().light_off();
  plant.run_for(std::chrono::milliseconds{100});
  line->refuses = false;
  machine->projector().light_off();
  plant.run_for(2 * RealMachine::kSearchInterval);
  CHECK(opened == 1);
  CHECK(count(machine->why_not_ready(), "light") == 0);
  CHECK(reported.back().kind == MachineEvent::Kind::Recovery);
}

TEST_CASE_METHOD(LightMachineFixture,
                 "The lid cuts the light line before the event loop notices, until it is closed again") {
  REQUIRE(light_on() == ProjectorReply::Ok);
  REQUIRE(line->level);
  const TimePoint lid_opened = plant.clock.now();
  plant.press(AxisInput::Lid, true);
  plant.run_threads_for(std::chrono::milliseconds{100});
  CHECK_FALSE(line->level);
  machine->projector().light_off();
  // The exposure ended with the cut, 60 us for the thread to wake after the lid was opened, not when the
  // event loop noticed.
  const auto span = machine->projector().last_light();
  REQUIRE((span && span->off_earliest));
  CHECK(*span->off_earliest - lid_opened == std::chrono::microseconds{60});
  CHECK(light_on() == ProjectorReply::Interlocked);
  CHECK(count(machine->projector().last_problem(), "stays off") == 1);
  CHECK_FALSE(line->level);
  CHECK(count(machine->why_not_ready(), "the lid is open") == 1);
  move_lid(false);
  CHECK(count(machine->why_not_ready(), "the lid") == 0);
  CHECK(light_on() == ProjectorReply::Ok);
}

TEST_CASE("A light line that is found after the axis, before it, or again is cut by the axis, too") {
  const bool light_late = GENERATE(false, true), axis_late = GENERATE(false, true);
  LightMachineFixture fixture(light_late, axis_late);
  fixture.chip_gone = fixture.axis_missing = false;
  fixture.plant.run_for(kPastSearch);
  REQUIRE(fixture.light_on() == ProjectorReply::Ok);
  fixture.line->refuses = fixture.chip_gone = true;
  fixture.machine->projector().light_off();
  fixture.plant.run_for(kPastSearch);
  fixture.move_lid(true);  // there is nothing to cut
  fixture.move_lid(false);
  fixture.chip_gone = false;
  fixture.plant.run_for(kPastSearch);
  REQUIRE(fixture.opened >= 3);
  REQUIRE(fixture.light_on() == ProjectorReply::Ok);
  fixture.move_lid(true);
  CHECK_FALSE(fixture.line->level);
}

TEST_CASE_METHOD(LightMachineFixture,
                 "A light that was cut because the axis' chip went can go on again when the axis is back") {
  REQUIRE(light_on() == ProjectorReply::Ok);
  axis_missing = true;
  plant.pull_chip();
  CHECK_FALSE(line->level);
  CHECK(light_on() == ProjectorReply::Interlocked);
  plant.run_for(kPastSearch);
  CHECK(light_on() == ProjectorReply::Interlocked);
  axis_missing = false;
  plant.run_for(kPastSearch);
  CHECK(light_on() == ProjectorReply::Ok);
}

TEST_CASE_METHOD(AxisMachineFixture,
                 "A missing light watchdog prevents printing, and its return is reported") {
  start();
  CHECK(count(machine->why_not_ready(), "watchdog") == 0);
  process = FileDescriptor();
  (void)watchdog.trip();  // reads the end of the socket
  CHECK(count(machine->why_not_ready(), "the light watchdog has died") == 1);
  CHECK(reported.empty());  // no light was on
  plant.run_for(2 * LightWatchdog::kStartLater);
  (void)watchdog.trip();
  CHECK(count(machine->why_not_ready(), "watchdog") == 0);
  REQUIRE(reported.size() == 1);
  CHECK(reported[0].kind == MachineEvent::Kind::Recovery);
  CHECK(reported[0].warnings.size() == 1);
}

TEST_CASE("The hardware check reports every device, whatever is wrong with the others") {
  VirtualClock clock;
  testing::NoDescriptors watcher;
  RealMachineConfig config = nowhere();
  config.axis.lid = GpioInputConfig{.line = {.chip = "gpiochip-missing", .line = "5"}};
  HardwareCheck check(clock, watcher, config, [](double, int) { return WakeUpLatency{}; });
  std::vector<std::string> devices;
  bool done = false;
  check.run(
      [&](const HardwareFinding& finding) {
        devices.push_back(finding.device);
        const bool computer = finding.device == "step thread";
        CHECK(finding.good == computer);
        CHECK((finding.what.find("-missing") == std::string::npos) == computer);
      },
      [&] { done = true; });
  while (clock.run_next()) {
  }
  CHECK(done);
  CHECK(devices == std::vector<std::string>{"step", "direction", "limit switch", "lid", "step thread",
                                            "light", "display", "projector"});
}

TEST_CASE(
    "The hardware check finds a top speed that the computer cannot sustain, and names one that it can") {
  VirtualClock clock;
  testing::NoDescriptors watcher;
  const auto finding_with = [&](const WakeUpLatency& wakes) {
    HardwareFinding found;
    HardwareCheck check(clock, watcher, nowhere(), [&](double rate, int priority) {
      CHECK(rate == 8'000);
      CHECK(priority == 40);
      return wakes;
    });
    check.run(
        [&](const HardwareFinding& finding) {
          if (finding.device == "step thread") found = finding;
        },
        [] {});
    return found;
  };
  const auto us = [](int microseconds) { return Duration{std::chrono::microseconds{microseconds}}; };
  const HardwareFinding quick = finding_with({.count = 12'000, .p99 = us(5), .worst = us(60)});
  CHECK((quick.good && !quick.warning));
  const HardwareFinding slow = finding_with({.count = 12'000, .p99 = us(5), .worst = us(4'000)});
  CHECK_FALSE(slow.good);
  CHECK(slow.what ==
        "8000 steps/s needed (10 mm/s); 99 % of wake-ups are at most 5 us late, the worst is 4000 us late: "
        "this computer sustains 4000 steps/s (5 mm/s)");
  const HardwareFinding refused =
      finding_with({.count = 12'000, .p99 = us(5), .worst = us(4'000), .refusals = {"no priority"}});
  CHECK((refused.good && refused.warning));
  CHECK(refused.what == slow.what + "; no priority");
}

TEST_CASE("The light of a process that died is turned off as far as its devices can be reached") {
  VirtualClock clock;
  testing::NoDescriptors watcher;
  const auto problems = [&](const LightConfig& config) {
    LightOff light(clock, watcher, config);
    std::optional<std::vector<std::string>> reported;
    light.run([&](const std::vector<std::string>& what) { reported = what; });
    CHECK_FALSE(reported);
    while (!reported && clock.run_next()) {
    }
    return reported.value();
  };
  LightConfig light{.line = nowhere().light, .projector = {}};
  CHECK(problems(light).size() == 1);
  light.projector = nowhere().projector;
  CHECK(problems(light).size() == 2);
  CHECK(problems({}).empty());
}

namespace {

// A light engine without a serial line, which answers at once.
class OtherProjector final : public Projector {
 public:
  explicit OtherProjector(Clock& clock) : clock_(clock) {}
  void power_on(Done done) override {
    answer_later([done = std::move(done)] { done(ProjectorReply::Ok); });
  }
  void light_on(Duration, LightOn light) override {
    lit = true;
    span_ = LightSpan{clock_.now(), clock_.now(), {}, {}};
    answer_later([this, light = std::move(light)] {
      light.sent(span_->on_earliest);
      light.done(ProjectorReply::Ok);
    });
  }
  void light_off() noexcept override {
    ++light_offs;
    if (stuck) return;
    lit = false;
    if (span_) span_->off_earliest = span_->off_latest = clock_.now();
  }
  void when_dark(std::function<void()> call) override {
    if (call && !lit) answer_later(std::move(call));
  }
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return span_; }
  void power_off() noexcept override { light_off(); }
  void ask_status(StatusDone done) override { done({}); }
  [[nodiscard]] std::string last_problem() const override { return "the engine is stuck"; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return lit ? "the engine is lit" : ""; }
  void may_warm_up() override { asked_after_find.emplace_back("may warm up"); }
  void confirm_dark(Done done) override { done(lit ? ProjectorReply::Refused : ProjectorReply::Ok); }
  void power_off_if_on() override { asked_after_find.emplace_back("power off if on"); }
  void on_event(std::function<void(const MachineEvent&)> call) override { tell = std::move(call); }
  [[nodiscard]] bool lost() const override { return is_lost; }
  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    if (!stuck) return {};
    return {"the light may be on: the engine is stuck"};
  }
  [[nodiscard]] std::string description() const override { return "engine at bus 1"; }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {"the engine is hot"}; }

  bool lit = true, stuck = false, is_lost = false;
  int light_offs = 0;
  std::vector<std::string> asked_after_find;
  std::function<void(const MachineEvent&)> tell;

 private:
  void answer_later(std::function<void()> call) { answer_ = clock_.call_after(Duration{0}, std::move(call)); }
  Clock& clock_;
  std::optional<LightSpan> span_;
  std::unique_ptr<Timer> answer_;
};

}  // namespace

TEST_CASE("A projector without a serial line is made dark, reported, lost and found like any other") {
  testing::Plant plant{GpioAxisConfig{}};
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(plant.clock, plant, process);
  RealMachineConfig config = nowhere();
  config.light.reset();
  OtherProjector* engine = nullptr;
  int opened = 0;
  RealMachine machine(plant.clock, plant, watchdog, config, {.projector = [&] {
                        ++opened;
                        auto made = std::make_unique<OtherProjector>(plant.clock);
                        engine = made.get();
                        return made;
                      }});
  std::vector<MachineEvent> reported;
  machine.on_event([&](const MachineEvent& event) { reported.push_back(event); });
  std::unique_ptr<Timer> again;
  const std::function<void()> watch = [&] {
    testing::watch_over_exposure(watchdog, process);
    again = plant.clock.call_after(LightWatchdog::kHeartbeat, watch);
  };
  CHECK_FALSE(engine->lit);
  CHECK(engine->asked_after_find == std::vector<std::string>{"may warm up", "power off if on"});
  CHECK(machine.description() == std::vector<std::string>{"projector: engine at bus 1"});
  CHECK(machine.warnings() == std::vector<std::string>{"the engine is hot"});

  std::optional<ProjectorReply> reply;
  machine.projector().light_on(std::chrono::seconds{1},
                               {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
  watch();
  plant.run([&] { return reply.has_value(); });
  CHECK(reply == ProjectorReply::Ok);
  CHECK(engine->lit);
  engine->stuck = true;
  machine.projector().light_off();
  CHECK(count(machine.why_not_ready(), "the light may be on: the engine is stuck") == 1);
  CHECK_FALSE(machine.projector().light_off_unconfirmed().empty());

  engine->is_lost = true;
  engine->tell({.kind = MachineEvent::Kind::Fault, .what = "the engine does not answer"});
  REQUIRE(reported.size() == 1);
  CHECK(count(machine.why_not_ready(), "the engine does not answer") == 1);
  plant.run_for(RealMachine::kFirstSearch + std::chrono::milliseconds{100});
  CHECK(opened == 2);
  CHECK_FALSE(engine->lit);
  CHECK(count(machine.why_not_ready(), "engine") == 0);
  REQUIRE(reported.size() == 2);
  CHECK(reported[1].what == "found projector: engine at bus 1");
  CHECK(reported[1].warnings == std::vector<std::string>{"the engine is hot"});
}
