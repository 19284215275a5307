// Tests on a virtual clock; the test is the light watchdog's process.
#include "hw/watchdog/watched_projector.hpp"

#include <string>
#include <vector>

#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

class NoDescriptors final : public DescriptorWatcher {
 public:
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int, std::function<void()>) override {
    return std::make_unique<Watch>();
  }
};

// Records its commands, and answers when the test says so.
class NotedProjector final : public testing::PlainProjector {
 public:
  void power_on(Done done) override { note("power on"), done(ProjectorReply::Ok); }
  void light_on(Duration, LightOn tell) override { note("light on"), answer = std::move(tell); }
  void light_off() noexcept override { note("light off"); }
  void when_dark(std::function<void()> call) override { dark = std::move(call); }
  [[nodiscard]] std::optional<LightSpan> last_light() const override { return light; }
  void power_off() noexcept override { note("power off"); }
  void ask_status(StatusDone done) override { done({}); }
  [[nodiscard]] std::string last_problem() const override { return "the projector's problem"; }
  [[nodiscard]] std::string light_off_unconfirmed() const override { return "light off is not confirmed"; }

  std::vector<std::string> commands;
  LightOn answer;
  std::function<void()> dark;
  std::optional<LightSpan> light;

 private:
  void note(const std::string& what) { commands.push_back(what); }
};

struct Bench {
  Bench() {
    watchdog.on_trouble([this](const std::string& what) { troubles.push_back(what); });
    (void)came();
  }

  // Returns the types of the messages that have been sent to the watchdog since the last call.
  std::vector<WatchdogMessageType> came() {
    std::vector<WatchdogMessageType> types;
    WatchdogPacket packet;
    while (receive_packet(process.get(), packet) == Received::Packet) {
      types.push_back(packet.type().value());
      if (const auto exposure = packet.as<ExposureMessage>()) last = exposure->exposure;
    }
    return types;
  }
  void reply(WatchdogMessageType type, LightTrip trip = LightTrip::None, bool line_off = false) {
    WatchdogReply message{};
    message.type = type;
    message.exposure = last.number;
    message.trip = trip;
    message.at = clock.now();
    message.line_off = line_off;
    CHECK(send_message(process.get(), message));
    (void)watchdog.trip();  // reads the message
  }
  void turn_on(Duration exposure = 2s) {
    projector.light_on(exposure, {.sent = [this](TimePoint at) { sent = at; },
                                  .done = [this](ProjectorReply reply) { answered = reply; }});
  }
  // Turns the light on, and has the watchdog and the projector confirm that.
  void shine() {
    turn_on();
    (void)came();
    reply(WatchdogMessageType::Heard);
    inner.light = LightSpan{clock.now(), clock.now(), {}, {}};
    inner.answer.sent(clock.now());
    inner.answer.done(ProjectorReply::Ok);
  }
  void wait(Duration duration) {
    bool over = false;
    const auto end = clock.call_after(duration, [&] { over = true; });
    while (!over && clock.run_next()) {
      const bool asked = !came().empty();
      if (asked && answers) reply(WatchdogMessageType::Heard);
    }
  }

  VirtualClock clock;
  NoDescriptors watcher;
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(clock, watcher, process);
  NotedProjector inner;
  int offered = 0;
  bool answers = true;
  WatchedProjector projector{inner, watchdog, [this] { ++offered; }};
  WatchedExposure last;
  std::vector<std::string> troubles;
  std::optional<TimePoint> sent;
  std::optional<ProjectorReply> answered;
};

}  // namespace

TEST_CASE("No light on is sent before the watchdog has confirmed that it watches") {
  Bench bench;
  bench.inner.light = LightSpan{};  // an earlier light
  bench.turn_on();
  CHECK(bench.inner.commands.empty());
  CHECK(bench.offered == 1);
  CHECK(bench.came() == std::vector{WatchdogMessageType::Arm});
  CHECK_FALSE(bench.projector.last_light());  // light on was never sent
  bench.reply(WatchdogMessageType::Heard);
  CHECK(bench.inner.commands == std::vector<std::string>{"light on"});
  bench.inner.answer.sent(TimePoint{300ms});
  CHECK(bench.sent == TimePoint{300ms});
  (void)bench.came();
  CHECK(bench.last.end == TimePoint{2300ms});
  CHECK_FALSE(bench.answered);
  bench.inner.answer.done(ProjectorReply::Ok);
  CHECK(bench.answered == ProjectorReply::Ok);
}

TEST_CASE("A watchdog that does not answer lets no light on through, and that is reported") {
  Bench bench;
  bench.answers = false;
  bench.turn_on();
  bench.wait(1s);
  CHECK(bench.inner.commands.empty());
  CHECK_FALSE(bench.answered);
  CHECK(bench.troubles ==
        std::vector<std::string>{"the light watchdog does not answer; no light is turned on without it"});
}

TEST_CASE("The light is turned off before the watchdog hears of it, and watched until it is confirmed dark") {
  Bench bench;
  bench.shine();
  (void)bench.came();
  bench.projector.light_off();
  CHECK(bench.inner.commands.back() == "light off");
  CHECK(bench.came() == std::vector{WatchdogMessageType::Heartbeat});
  CHECK(bench.last.off_asked);
  bool dark = false;
  bench.projector.when_dark([&] { dark = true; });
  CHECK(bench.came().empty());
  bench.inner.dark();
  CHECK(dark);
  CHECK(bench.came() == std::vector{WatchdogMessageType::Disarm});
}

TEST_CASE("Darkness ends the watch even if no one else waits for it") {
  for (const bool power : {false, true}) {
    Bench bench;
    bench.shine();
    power ? bench.projector.power_off() : bench.projector.light_off();
    (void)bench.came();
    REQUIRE(bench.inner.dark);
    bench.inner.dark();
    CHECK(bench.came() == std::vector{WatchdogMessageType::Disarm});
  }
}

TEST_CASE("A light off that overtakes the watchdog's confirmation keeps the light off") {
  Bench bench;
  bench.turn_on();
  (void)bench.came();
  bench.projector.light_off();
  bench.reply(WatchdogMessageType::Heard);
  CHECK(bench.inner.commands == std::vector<std::string>{"light off"});
}

TEST_CASE("A light off while no light is on does not drop a wait for darkness") {
  Bench bench;
  bool dark = false;
  bench.projector.when_dark([&] { dark = true; });
  bench.projector.light_off();
  CHECK(bench.came().empty());
  bench.inner.dark();
  CHECK(dark);
}

TEST_CASE("A light that the watchdog turned off by its line went off then, not when that was noticed") {
  for (const bool by_line : {true, false}) {
    Bench bench;
    bench.shine();
    (void)bench.came();
    bench.wait(1s);
    bench.reply(WatchdogMessageType::Tripped, LightTrip::Silence, by_line);
    bench.wait(20s);
    bench.inner.light->off_earliest = bench.inner.light->off_latest = bench.clock.now();
    const LightSpan light = bench.projector.last_light().value();
    CHECK(light.least() == 1s);
    // For a projector's own light, only its reply is proof.
    CHECK(light.most(bench.clock.now()) == (by_line ? 1s : 21s));
  }
}

TEST_CASE("A trip of the watchdog does not affect the times of the next light") {
  Bench bench;
  bench.shine();
  (void)bench.came();
  bench.reply(WatchdogMessageType::Tripped, LightTrip::Silence, true);
  bench.projector.light_off();
  bench.inner.dark();
  bench.wait(5s);
  bench.shine();
  bench.wait(1s);
  CHECK(bench.projector.last_light()->most(bench.clock.now()) == 1s);
}

TEST_CASE("Another projector takes the place of one that is gone") {
  Bench bench;
  NotedProjector another;
  bench.projector.watch(another);
  bench.projector.light_off();
  CHECK(bench.inner.commands.empty());
  CHECK(another.commands == std::vector<std::string>{"light off"});
  CHECK(bench.projector.light_off_unconfirmed() == "light off is not confirmed");
}
