// Tests on a virtual clock; the test is the light watchdog's process.
#include "hw/watchdog/watched_projector.hpp"

#include "tests/catch.hpp"
#include "tests/hw/noted_projector.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

namespace {

struct WatchedProjectorFixture : testing::ReadyWatchdogFixture {
  WatchedProjectorFixture() {
    inner.answers_light_on = false;
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
    testing::send_reply(process, message);
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
    pass(duration, [this] {
      const bool asked = !came().empty();
      if (asked && answers) reply(WatchdogMessageType::Heard);
    });
  }

  std::vector<std::string> commands;
  testing::NotedProjector inner{commands};
  int offered = 0;
  bool answers = true;
  WatchedProjector projector{inner, watchdog, [this] { ++offered; }};
  WatchedExposure last;
  std::vector<std::string> troubles;
  std::optional<TimePoint> sent;
  std::optional<ProjectorReply> answered;
};

}  // namespace

TEST_CASE_METHOD(WatchedProjectorFixture,
                 "No light on is sent before the watchdog has confirmed that it watches") {
  inner.light = LightSpan{};  // an earlier light
  turn_on();
  CHECK(commands.empty());
  CHECK(offered == 1);
  CHECK(came() == std::vector{WatchdogMessageType::Arm});
  CHECK_FALSE(projector.last_light());  // light on was never sent
  reply(WatchdogMessageType::Heard);
  CHECK(commands == std::vector<std::string>{"light on"});
  inner.answer.sent(TimePoint{300ms});
  CHECK(sent == TimePoint{300ms});
  (void)came();
  CHECK(last.end == TimePoint{2300ms});
  CHECK_FALSE(answered);
  inner.answer.done(ProjectorReply::Ok);
  CHECK(answered == ProjectorReply::Ok);
}

TEST_CASE_METHOD(WatchedProjectorFixture,
                 "A watchdog that does not answer lets no light on through, and that is reported") {
  answers = false;
  turn_on();
  wait(1s);
  CHECK(commands.empty());
  CHECK_FALSE(answered);
  CHECK(troubles ==
        std::vector<std::string>{"the light watchdog does not answer; no light is turned on without it"});
}

TEST_CASE_METHOD(
    WatchedProjectorFixture,
    "The light is turned off before the watchdog hears of it, and watched until it is confirmed dark") {
  shine();
  (void)came();
  projector.light_off();
  CHECK(commands.back() == "light off");
  CHECK(came() == std::vector{WatchdogMessageType::Heartbeat});
  CHECK(last.off_asked);
  bool dark = false;
  projector.when_dark([&] { dark = true; });
  CHECK(came().empty());
  inner.dark();
  CHECK(dark);
  CHECK(came() == std::vector{WatchdogMessageType::Disarm});
}

TEST_CASE("Darkness ends the watch even if no one else waits for it") {
  for (const bool power : {false, true}) {
    WatchedProjectorFixture fixture;
    fixture.shine();
    power ? fixture.projector.power_off() : fixture.projector.light_off();
    (void)fixture.came();
    REQUIRE(fixture.inner.dark);
    fixture.inner.dark();
    CHECK(fixture.came() == std::vector{WatchdogMessageType::Disarm});
  }
}

TEST_CASE_METHOD(WatchedProjectorFixture,
                 "A light off that overtakes the watchdog's confirmation keeps the light off") {
  turn_on();
  (void)came();
  projector.light_off();
  reply(WatchdogMessageType::Heard);
  CHECK(commands == std::vector<std::string>{"light off"});
}

TEST_CASE_METHOD(WatchedProjectorFixture,
                 "A light off while no light is on does not drop a wait for darkness") {
  bool dark = false;
  projector.when_dark([&] { dark = true; });
  projector.light_off();
  CHECK(came().empty());
  inner.dark();
  CHECK(dark);
}

TEST_CASE("A light that the watchdog turned off by its line went off then, not when that was noticed") {
  for (const bool by_line : {true, false}) {
    WatchedProjectorFixture fixture;
    fixture.shine();
    (void)fixture.came();
    fixture.wait(1s);
    fixture.reply(WatchdogMessageType::Tripped, LightTrip::Silence, by_line);
    fixture.wait(20s);
    fixture.inner.light->off_earliest = fixture.inner.light->off_latest = fixture.clock.now();
    const LightSpan light = fixture.projector.last_light().value();
    CHECK(light.least() == 1s);
    // For a projector's own light, only its reply is proof.
    CHECK(light.most(fixture.clock.now()) == (by_line ? 1s : 21s));
  }
}

TEST_CASE_METHOD(WatchedProjectorFixture,
                 "A trip of the watchdog does not affect the times of the next light") {
  shine();
  (void)came();
  reply(WatchdogMessageType::Tripped, LightTrip::Silence, true);
  projector.light_off();
  inner.dark();
  wait(5s);
  shine();
  wait(1s);
  CHECK(projector.last_light()->most(clock.now()) == 1s);
}

TEST_CASE_METHOD(WatchedProjectorFixture, "Another projector takes the place of one that is gone") {
  std::vector<std::string> others;
  testing::NotedProjector another(others);
  another.unconfirmed = "light off is not confirmed";
  projector.watch(another);
  projector.light_off();
  CHECK(commands.empty());
  CHECK(others == std::vector<std::string>{"light off"});
  CHECK(projector.light_off_unconfirmed() == "light off is not confirmed");
}
