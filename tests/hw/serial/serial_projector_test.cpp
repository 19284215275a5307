#include "hw/serial/serial_projector.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/serial/projector_tables.hpp"
#include "tests/hw/serial/scripted_channel.hpp"
#include "tests/hw/virtual_time_fixture.hpp"

using namespace contourd;
using namespace contourd::testing;
using namespace std::chrono_literals;

namespace {

using Messages = std::vector<std::string>;

// A projector of the text table that behaves, with the messages that it gets and the results of the calls.
struct SerialProjectorFixture : VirtualTimeFixture {
  explicit SerialProjectorFixture(ProjectorTable table = text_table())
      : projector(channel, clock, std::move(table)) {
    behave_again();
    projector.on_event([this](const MachineEvent& one) { events.push_back(one); });
  }

  void behave(const std::string& message) {
    if (message == "~0000 1\r" && clock.now() >= deaf_until) is_on = true;
    if (message == "~0000 0\r") is_on = false;
    if (message == "~0002 0\r") light = true;
    if (message == "~0002 1\r") light = false;
    if (message == "~00124 1\r") return channel.send(is_on ? "OK1\r" : "OK0\r", reply);
    if (message == "~00108 1\r") return channel.send("OK1234\r", reply);
    channel.send("P\r", reply);
  }
  void fall_silent() {
    channel.projector = [](const std::string&) {};
  }
  void behave_again() {
    channel.projector = [this](const std::string& message) { behave(message); };
  }
  // Behaves, but for this message.
  void refuse(const std::string& refused) {
    channel.projector = [this, refused](const std::string& message) {
      message == refused ? channel.send("F\r") : behave(message);
    };
  }
  void answer_always(const std::string& bytes) {
    channel.projector = [this, bytes](const std::string&) { channel.send(bytes, reply); };
  }

  void start_power_on() {
    answer.reset();
    projector.power_on([this](ProjectorReply r) { answer = r, answered_at = clock.now(); });
  }
  void start_light_on(Duration exposure = 10s) {
    answer.reset(), sent_at.reset();
    projector.light_on(exposure,
                       {.sent = [this](TimePoint earliest) { sent_at = earliest; },
                        .done = [this](ProjectorReply r) { answer = r, answered_at = clock.now(); }});
  }
  void wait_for_answer() {
    while (!answer && clock.run_next()) {
    }
    REQUIRE(answer);
  }
  ProjectorReply answer_to_power_on() {
    start_power_on();
    wait_for_answer();
    return *answer;
  }
  ProjectorReply answer_to_light_on() {
    start_light_on();
    wait_for_answer();
    return *answer;
  }
  void power_on() {
    REQUIRE(answer_to_power_on() == ProjectorReply::Ok);
    channel.sent.clear();
  }
  void light_on() {
    REQUIRE(answer_to_light_on() == ProjectorReply::Ok);
    channel.sent.clear();
  }
  [[nodiscard]] std::ptrdiff_t times_sent(const std::string& message) const {
    return std::ranges::count(channel.sent, message, &ScriptedChannel::Sent::message);
  }

  ScriptedChannel channel{clock};
  Duration reply = 20ms;
  TimePoint deaf_until{};
  bool is_on = false, light = false;
  std::vector<MachineEvent> events;
  std::optional<ProjectorReply> answer;
  TimePoint answered_at{};
  std::optional<TimePoint> sent_at;
  SerialProjector projector;
};

}  // namespace

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a serial projector that is off is turned on, warmed up, asked again and made dark") {
  light = true;  // as the projector comes up
  CHECK(answer_to_power_on() == ProjectorReply::Ok);
  CHECK(channel.messages() == Messages{"~00124 1\r", "~0000 1\r", "~0002 1\r", "~00124 1\r", "~0002 1\r"});
  CHECK_FALSE(light);
  CHECK(now() >= 30s);
  CHECK(now() < 31s);  // four commands and their gaps beside the warm-up
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector that refuses light off while it warms up gets it again and again after power on") {
  std::optional<TimePoint> on_at;
  channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r") on_at = clock.now(), light = true;  // with a start-up picture
    if (message == "~0002 1\r" && clock.now() - *on_at < 25s) return channel.send("F\r");
    behave(message);
  };
  start_power_on();
  pass(20s);
  REQUIRE(channel.sent.size() > 12);  // a second between attempts, and a reply and a gap
  CHECK(channel.sent[2].message == "~0002 1\r");
  CHECK(channel.sent[2].at - *on_at < 200ms);  // power on's reply after 20 ms, and the gap of 100 ms
  CHECK(light);
  pass(7s);
  CHECK_FALSE(light);
  CHECK_FALSE(answer);  // the projector is not warm yet
  wait_for_answer();
  CHECK(answer == ProjectorReply::Ok);
  CHECK(events.empty());
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector that is deaf while it warms up is made dark after that, without a machine event") {
  std::optional<TimePoint> on_at;
  channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r" && !on_at) on_at = clock.now(), light = is_on = true;
    if (on_at && message != "~0000 1\r" && clock.now() - *on_at < 29900ms) return;
    behave(message);
  };
  CHECK(answer_to_power_on() == ProjectorReply::Ok);
  CHECK_FALSE(light);
  CHECK(events.empty());
}

TEST_CASE_METHOD(SerialProjectorFixture, "a projector that refuses light off when it is warm is reported") {
  refuse("~0002 1\r");
  CHECK(answer_to_power_on() == ProjectorReply::Refused);
  CHECK(now() >= 30s);
  CHECK(now() < 33s);  // an attempt a second
  CHECK(events.size() == 1);
}

TEST_CASE_METHOD(SerialProjectorFixture, "a projector that warms up a second time can be turned off") {
  power_on();
  projector.power_off();
  pass(70s);
  REQUIRE_FALSE(is_on);
  start_power_on();
  pass(10s);
  REQUIRE(is_on);
  light = true;
  projector.power_off();
  pass(5s);
  CHECK_FALSE(is_on);
  CHECK_FALSE(light);
  CHECK_FALSE(answer);
}

TEST_CASE_METHOD(SerialProjectorFixture, "a serial projector that is on already is not warmed up again") {
  is_on = light = true;
  start_power_on();
  wait_for_answer();
  CHECK(channel.messages() == Messages{"~00124 1\r", "~0002 1\r"});
  CHECK(now() < 1s);
  CHECK_FALSE(light);
}

TEST_CASE_METHOD(SerialProjectorFixture, "light on is reported when the serial projector's reply has come") {
  power_on();
  pass(1s);
  const TimePoint asked = clock.now();
  light_on();
  CHECK(light);
  CHECK(answered_at - asked == 20ms);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "light off is sent in the very call, ahead of a light on that waits for its reply") {
  power_on();
  pass(1s);
  reply = 500ms;
  start_light_on();
  pass(200ms);
  channel.sent.clear();
  const TimePoint asked = clock.now();
  projector.light_off();
  REQUIRE(channel.sent.size() == 1);
  CHECK(channel.sent[0].message == "~0002 1\r");
  CHECK(channel.sent[0].at == asked);
  pass(5s);
  CHECK_FALSE(answer);  // dropped
  CHECK(events.empty());
  CHECK_FALSE(light);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "light off waits only for the gap that the projector needs after a command") {
  power_on();
  pass(1s);
  reply = 500ms;
  start_light_on();
  const TimePoint asked = clock.now();
  projector.light_off();
  pass(1s);
  REQUIRE(channel.sent.size() >= 2);  // and again when light on's reply has come
  // 8 bytes of 10 bits at 9600 baud are 8.333 ms.
  CHECK(channel.sent[1].at - asked == 100ms + std::chrono::nanoseconds{8'333'333});
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "the late reply to a light on does not confirm the light off after it") {
  power_on();
  pass(1s);
  channel.projector = [&](const std::string& message) {
    if (message == "~0002 0\r") channel.send("P\r", 300ms);  // and light off is lost
  };
  start_light_on();
  pass(200ms);
  projector.light_off();
  pass(10s);
  CHECK(events.size() == 1);
  CHECK(channel.sent.size() > 4);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a reply to light on that comes late and twice does not confirm the light off after it") {
  power_on();
  pass(1s);
  int light_offs = 0;
  channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r" && ++light_offs == 1) return;  // lost
    if (message != "~0002 0\r") return behave(message);
    light = true;
    channel.send("P\rP\r", 300ms);
  };
  start_light_on();
  pass(200ms);
  bool dark = false;
  projector.light_off();
  projector.when_dark([&] { dark = true; });
  pass(110ms);
  CHECK(light);
  CHECK_FALSE(dark);
  // The gap of 100 ms, the reply's 20 ms.
  pass(125ms);
  CHECK_FALSE(light);
  CHECK(dark);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a reply to light off that comes late and twice does not confirm the power off after it") {
  power_on();
  pass(1s);
  int light_offs = 0, power_offs = 0;
  channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r" && ++power_offs == 1) return;  // lost
    if (message != "~0002 1\r") return behave(message);
    // The first two light offs are both answered, and the second one's reply comes twice.
    ++light_offs == 1 ? channel.send("P\r", 1100ms) : channel.send("P\rP\r", 200ms);
  };
  projector.power_off();
  pass(1300ms);
  REQUIRE(power_offs == 1);
  pass(500ms);
  CHECK(power_offs == 3);  // the second power off's reply might be light off's third
  CHECK_FALSE(is_on);
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "light off is repeated until the projector confirms it, and reported once when that takes too long") {
  power_on();
  light_on();
  fall_silent();
  projector.light_off();
  pass(2900ms);
  CHECK(events.empty());
  pass(300ms);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(events[0].what ==
        "the light may be on: the projector at /dev/ttyUSB7 did not answer \"light off\" in 3 tries of 1000 "
        "ms: is it "
        "connected, and set to 9600 baud?");
  pass(60s);
  CHECK(channel.sent.size() > 15);
  for (const std::string& message : channel.messages())
    CHECK(message == "~0002 1\r");
  CHECK(events.size() == 1);

  CHECK_FALSE(projector.why_not_ready().empty());
  CHECK(projector.light_off_unconfirmed().find("did not answer \"light off\"") != std::string::npos);

  behave_again();
  pass(2s);
  CHECK_FALSE(light);
  CHECK(projector.why_not_ready().empty());
  CHECK(projector.light_off_unconfirmed().empty());
  REQUIRE(events.size() == 2);
  CHECK(events[1].kind == MachineEvent::Kind::Recovery);
  CHECK(events[1].what == "the projector at /dev/ttyUSB7 has confirmed that its light is off");
  channel.sent.clear();
  pass(60s);
  for (const std::string& message : channel.messages())
    CHECK(message == "~00124 1\r");  // the question whether it is still on
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "the reason why the light may be on is still reported after another command has failed") {
  power_on();
  light_on();
  channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") return channel.send("F\r");
    if (message != "~0000 0\r") behave(message);
  };
  projector.power_off();
  for (int second = 0; second < 20; ++second) {
    pass(1s);
    CHECK_FALSE(projector.light_off_unconfirmed().empty());
    CHECK(projector.light_off_unconfirmed().find("power off") == std::string::npos);
  }
  CHECK_FALSE(projector.why_not_ready().empty());
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a light is not turned on again while its light off is not confirmed") {
  power_on();
  light_on();
  fall_silent();
  projector.light_off();
  pass(4s);
  channel.sent.clear();
  CHECK(answer_to_light_on() == ProjectorReply::Refused);
  pass(10s);
  for (const std::string& message : channel.messages())
    CHECK(message == "~0002 1\r");
}

TEST_CASE_METHOD(SerialProjectorFixture, "light on that is not confirmed is followed by light off") {
  power_on();
  pass(1s);
  channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") behave(message);
    if (message == "~0002 0\r") light = true;  // obeyed, but not answered
  };
  CHECK(answer_to_light_on() == ProjectorReply::NoAnswer);
  CHECK(projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"light on\" in 1 try of 1000 ms: is it connected, "
        "and set to 9600 baud?");
  pass(3s);
  CHECK(times_sent("~0002 0\r") == 1);
  CHECK_FALSE(light);
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector that is silent from the start is asked whether it is on, without a machine event") {
  fall_silent();
  projector.light_off();
  CHECK(channel.messages() == Messages{"~0002 1\r"});
  pass(60s);
  CHECK(channel.messages() ==
        Messages{"~0002 1\r", "~0002 1\r", "~0002 1\r", "~00124 1\r", "~00124 1\r", "~00124 1\r"});
  CHECK(events.empty());
}

TEST_CASE_METHOD(SerialProjectorFixture, "a projector that is off and refuses light off is dark") {
  refuse("~0002 1\r");  // as Optoma's do in standby
  projector.light_off();
  pass(60s);
  CHECK(channel.messages() == Messages{"~0002 1\r", "~00124 1\r"});
  CHECK(events.empty());
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector found on that does not confirm light off is reported once, and gets it again and again") {
  is_on = light = true;
  bool hears = false;
  channel.projector = [&](const std::string& message) {
    if (hears || message != "~0002 1\r") behave(message);
  };
  projector.light_off();
  pass(60s);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(events[0].what.starts_with(
      "the light may be on: the projector at /dev/ttyUSB7 did not answer \"light off\""));
  CHECK(channel.sent.size() > 15);
  hears = true;
  pass(2s);
  CHECK_FALSE(light);
  channel.sent.clear();
  pass(60s);
  CHECK(channel.sent.empty());
  REQUIRE(events.size() == 2);
  CHECK(events[1].kind == MachineEvent::Kind::Recovery);
}

TEST_CASE_METHOD(SerialProjectorFixture, "garbage in answer to the first light off is reported once") {
  answer_always("\x8f\xe0\x03\xff");
  projector.light_off();
  pass(60s);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(
      events[0].what.starts_with("the light may be on: the projector at /dev/ttyUSB7 answered "
                                 "\"light off\" in 3 tries of 1000 ms with \""));
}

TEST_CASE("confirm_dark answers when the projector has confirmed, or was asked often enough") {
  const auto reply_of = [](SerialProjectorFixture& fixture) {
    std::optional<ProjectorReply> reply;
    fixture.projector.confirm_dark([&](ProjectorReply r) { reply = r; });
    CHECK_FALSE(reply);
    fixture.pass(30s);
    REQUIRE(reply);
    return *reply;
  };
  {
    SerialProjectorFixture on;
    on.is_on = on.light = true;
    CHECK(reply_of(on) == ProjectorReply::Ok);
    CHECK(on.channel.messages() == Messages{"~0002 1\r"});
    CHECK_FALSE(on.light);
  }
  {
    SerialProjectorFixture standby;
    standby.channel.projector = [&](const std::string& message) {
      standby.channel.send(message == "~00124 1\r" ? "OK0\r" : "F\r");
    };
    CHECK(reply_of(standby) == ProjectorReply::Ok);
  }
  {
    SerialProjectorFixture refuses;
    refuses.channel.projector = [&](const std::string& message) {
      refuses.channel.send(message == "~00124 1\r" ? "OK1\r" : "F\r");
    };
    CHECK(reply_of(refuses) == ProjectorReply::Refused);
    CHECK(refuses.projector.last_problem() ==
          "the projector at /dev/ttyUSB7 refused \"light off\": it answered \"F\"");
  }
  {
    SerialProjectorFixture silent;
    silent.fall_silent();
    CHECK(reply_of(silent) == ProjectorReply::NoAnswer);
    CHECK(
        silent.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"light off\" in 3 tries of 1000 ms: is it connected, "
        "and set to 9600 baud?");
  }
  {
    SerialProjectorFixture garbled;
    garbled.answer_always("\x8f\xe0");
    CHECK(reply_of(garbled) == ProjectorReply::NoAnswer);
  }
  {
    SerialProjectorFixture lost;
    lost.channel.unplug();
    CHECK(reply_of(lost) == ProjectorReply::NoAnswer);
  }
  {
    // The part of a table that --light-off knows.
    ProjectorTable table = text_table();
    table.light_on.reset();
    table.power.reset();
    SerialProjectorFixture partial(table);
    partial.fall_silent();
    CHECK(reply_of(partial) == ProjectorReply::NoAnswer);
    CHECK(partial.channel.messages() == Messages{"~0002 1\r", "~0002 1\r", "~0002 1\r"});
  }
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a print that begins while the light is not yet known to be off gets its answer") {
  is_on = light = true;
  bool hears = false;
  channel.projector = [&](const std::string& message) {
    if (hears || message != "~0002 1\r") behave(message);
  };
  projector.light_off();
  start_power_on();
  pass(20s);
  CHECK(answer == ProjectorReply::NoAnswer);
  CHECK(events.size() == 1);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a silent projector is asked again as often as its table says, then given up") {
  fall_silent();
  CHECK(answer_to_power_on() == ProjectorReply::NoAnswer);
  CHECK(channel.messages() ==
        Messages{"~00124 1\r", "~00124 1\r", "~00124 1\r", "~0000 1\r", "~0000 1\r", "~0000 1\r"});
  CHECK(projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"power on\" in 3 tries of 1000 ms: is it connected, "
        "and set to 9600 "
        "baud?");
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector that ignores questions while it is off is turned on all the same") {
  channel.projector = [&](const std::string& message) {
    if (is_on || message == "~0000 1\r") behave(message);
  };
  power_on();
  CHECK(is_on);
}

TEST_CASE_METHOD(SerialProjectorFixture, "garbage, as from a wrong baud rate, is shown in the message") {
  answer_always("\x8f\xe0\x03\xff");
  CHECK(answer_to_power_on() == ProjectorReply::NoAnswer);
  CHECK(
      projector.last_problem() ==
      "the projector at /dev/ttyUSB7 answered \"power on\" in 3 tries of 1000 ms with "
      "\"\\x8F\\xE0\\x03\\xFF\\x8F\\xE0\\x03\\xFF\\x8F\\xE0\\x03\\xFF\", which is not a reply to it: is its "
      "baud rate 9600, and is the table \"Optoma\" the right one for it?");
}

TEST_CASE_METHOD(SerialProjectorFixture, "a refusal is distinguished from silence, and its bytes are shown") {
  power_on();
  pass(1s);
  channel.projector = [&](const std::string& message) {
    channel.send(message == "~0002 0\r" ? "F\r" : "P\r");
  };
  CHECK(answer_to_light_on() == ProjectorReply::Refused);
  CHECK(projector.last_problem() == "the projector at /dev/ttyUSB7 refused \"light on\": it answered \"F\"");
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a reply without its line end counts when nothing more has come in time") {
  power_on();
  pass(1s);
  answer_always("P");
  CHECK(answer_to_light_on() == ProjectorReply::Ok);
  CHECK(channel.sent.size() == 1);
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a reply that comes after a command was sent again answers it, and its repetition answers no other") {
  power_on();
  pass(1s);
  reply = 1100ms;  // the table's timeout is 1 s
  const TimePoint start = clock.now();
  answer.reset();
  projector.ask_status([&](const ProjectorStatus& status) {
    if (!answer) answer = status.reply, answered_at = clock.now();
  });
  wait_for_answer();
  CHECK(answer == ProjectorReply::Ok);
  CHECK(channel.messages() == Messages{"~00124 1\r", "~00124 1\r", "~00108 1\r", "~00108 1\r"});
  CHECK(answered_at - start == 2 * 1100ms + 100ms);  // with the gap between the two questions
  // The second reply is still on its way when light off, which is lost, waits for its own.
  fall_silent();
  projector.light_off();
  pass(5s);
  CHECK(events.empty());  // no light was ever asked for
  CHECK(channel.messages().back() != "~0002 0\r");
}

TEST_CASE("light on is sent once, and the light counts from its first byte, whatever the reply does") {
  for (const bool obeys : {true, false}) {
    CAPTURE(obeys);
    SerialProjectorFixture fixture;
    fixture.power_on();
    fixture.pass(1s);
    fixture.channel.projector = [&](const std::string& message) {
      if (message != "~0002 0\r") return fixture.behave(message);
      fixture.light = obeys;  // and the reply is lost
    };
    const TimePoint asked = fixture.clock.now();
    fixture.start_light_on();
    fixture.wait_for_answer();
    CHECK(fixture.sent_at == asked);
    CHECK(fixture.answer == ProjectorReply::NoAnswer);
    fixture.pass(3s);
    const auto light = fixture.projector.last_light();
    REQUIRE(light);
    CHECK(light->on_earliest == asked);
    CHECK_FALSE(light->on_latest);
    // The reply was waited for during a second from the command's last byte, then light off was sent. The
    // first reply may be light on's and the second a repetition of it, so the third counts; each takes a gap
    // of 100 ms and a reply of 20 ms.
    CHECK(light->most(fixture.clock.now()) > 1240ms);
    CHECK(light->most(fixture.clock.now()) < 1300ms);
    CHECK(light->least() == Duration{0});
    CHECK(fixture.times_sent("~0002 0\r") == 1);
  }
}

TEST_CASE("a light that comes no sooner than its projector's latency counts from then on") {
  ProjectorTable table = text_table();
  table.latency = 150ms;
  SerialProjectorFixture fixture(table);
  fixture.power_on();
  fixture.pass(1s);
  const TimePoint asked = fixture.clock.now();
  fixture.start_light_on();
  fixture.wait_for_answer();
  CHECK(fixture.sent_at == asked + 150ms);
}

TEST_CASE("after a lost reply to light on the projector is asked, where it can be, whether the light is on") {
  ProjectorTable table = text_table();
  table.light = text_command("light", "~00355 1", {{ReplyMeaning::On, "OK0"}, {ReplyMeaning::Off, "OK1"}});
  for (const bool obeyed : {true, false}) {
    CAPTURE(obeyed);
    SerialProjectorFixture fixture(table);
    fixture.power_on();
    fixture.pass(1s);
    fixture.channel.projector = [&](const std::string& message) {
      if (message == "~00355 1\r") return fixture.channel.send(fixture.light ? "OK0\r" : "OK1\r");
      if (message != "~0002 0\r") return fixture.behave(message);
      fixture.light = obeyed;
    };
    CHECK(fixture.answer_to_light_on() == (obeyed ? ProjectorReply::Ok : ProjectorReply::NoAnswer));
    CHECK(fixture.projector.last_light()->on_latest.has_value() == obeyed);
    fixture.pass(3s);
    CHECK(fixture.light == obeyed);
    // Light off is sent although light on was not obeyed.
    CHECK((fixture.times_sent("~0002 1\r") > 0) == !obeyed);
  }
}

TEST_CASE("a reply to light on that may be a repeated one to light off does not confirm that it is on") {
  for (const bool asked : {true, false}) {
    for (const bool obeyed : {true, false}) {
      CAPTURE(asked, obeyed);
      ProjectorTable table = text_table();
      if (asked)
        table.light =
            text_command("light", "~00355 1", {{ReplyMeaning::On, "OK0"}, {ReplyMeaning::Off, "OK1"}});
      SerialProjectorFixture fixture(table);
      fixture.power_on();
      fixture.light_on();
      fixture.channel.projector = [&](const std::string& message) {
        if (message == "~00355 1\r") return fixture.channel.send(fixture.light ? "OK0\r" : "OK1\r");
        fixture.light = message == "~0002 0\r" && obeyed;
        // The second light off is answered for both of them; light on's reply looks like one more of these.
        if (message == "~0002 0\r") return fixture.channel.send("P\r");
        if (fixture.times_sent("~0002 1\r") == 2) fixture.channel.send("P\rP\r");
      };
      fixture.projector.light_off();
      fixture.pass(1500ms);
      REQUIRE(fixture.projector.light_off_unconfirmed().empty());
      CHECK(fixture.answer_to_light_on() ==
            (asked && !obeyed ? ProjectorReply::NoAnswer : ProjectorReply::Ok));
      CHECK(fixture.projector.last_light()->on_latest.has_value() == (asked && obeyed));
      if (asked && !obeyed)
        CHECK(fixture.projector.last_problem().find("has not confirmed that its light is on") !=
              std::string::npos);
    }
  }
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "the callback of when_dark is called when light off is confirmed, not before") {
  power_on();
  std::optional<TimePoint> dark_at;
  const auto wait = [&] {
    dark_at.reset();
    projector.when_dark([&] { dark_at = clock.now(); });
    CHECK_FALSE(dark_at);
  };
  wait();
  pass(1s);
  CHECK(dark_at);  // dark from the start
  light_on();
  wait();
  pass(1s);
  CHECK_FALSE(dark_at);
  fall_silent();
  const TimePoint off = clock.now();
  projector.light_off();
  pass(2500ms);
  CHECK_FALSE(dark_at);
  behave_again();
  pass(2s);
  REQUIRE(dark_at);
  CHECK_FALSE(light);
  CHECK(projector.last_light()->off_earliest == off);
  CHECK(projector.last_light()->off_latest == dark_at);
  wait();
  start_light_on();  // drops the wait for darkness
  pass(1s);
  CHECK_FALSE(dark_at);
}

TEST_CASE_METHOD(SerialProjectorFixture, "a light on is refused while a light off is not confirmed") {
  power_on();
  light_on();
  projector.light_off();
  CHECK(answer_to_light_on() == ProjectorReply::Refused);
  CHECK_FALSE(sent_at);
  pass(1s);
  light_on();
  CHECK(light);
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector is not asked whether it is still on if light off would have to wait for the answer") {
  power_on();
  pass(3900ms);
  start_light_on(2s);  // the question would be due after 1.1 s of it
  pass(1950ms);
  CHECK(times_sent("~00124 1\r") == 0);
  projector.light_off();
  CHECK(channel.sent.back().at == clock.now());
  pass(8s);
  channel.sent.clear();
  start_light_on(30s);
  pass(20s);
  CHECK(times_sent("~00124 1\r") >= 3);
}

TEST_CASE("a power off that no projector answers is checked where it can be asked, and sent again") {
  ProjectorTable table = text_table();
  table.power_off.replies.clear();
  SerialProjectorFixture fixture(table);
  fixture.power_on();
  fixture.channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r" && fixture.times_sent(message) == 1) return;  // lost
    fixture.behave(message);
  };
  fixture.projector.power_off();
  fixture.pass(4s);
  CHECK(fixture.is_on);
  fixture.pass(10s);
  CHECK_FALSE(fixture.is_on);
  fixture.channel.sent.clear();
  fixture.pass(60s);
  CHECK(fixture.channel.sent.empty());  // the projector has said that it is off
  CHECK(fixture.events.empty());
}

TEST_CASE("a projector that stays on though it was turned off is reported, even if power off has no reply") {
  ProjectorTable table = text_table();
  table.power_off.replies.clear();
  SerialProjectorFixture fixture(table);
  fixture.power_on();
  fixture.channel.projector = [&](const std::string& message) {
    if (message != "~0000 0\r") fixture.behave(message);
  };
  fixture.projector.power_off();
  fixture.pass(60s);
  REQUIRE(fixture.events.size() == 1);
  CHECK(fixture.events[0].what ==
        "the lamp may be on: the projector at /dev/ttyUSB7 has not confirmed that it is off");
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "power on right after power off waits until the lamp has cooled down") {
  power_on();
  projector.power_off();
  pass(1s);
  CHECK(channel.messages() == Messages{"~0002 1\r", "~0000 0\r"});
  CHECK_FALSE(is_on);
  const TimePoint off = clock.now() - 1s;
  channel.sent.clear();
  CHECK(answer_to_power_on() == ProjectorReply::Ok);
  REQUIRE(channel.sent.size() == 5);
  CHECK(channel.sent[1].message == "~0000 1\r");
  CHECK(channel.sent[1].at - off >= 60s);
  CHECK(channel.sent[1].at - off < 61s);  // power off was confirmed a few replies after it was asked
}

TEST_CASE("power on right after power off waits for the cool-down too where a projector cannot be asked") {
  ProjectorTable table = text_table();
  table.power.reset();
  SerialProjectorFixture fixture(table);
  fixture.power_on();
  fixture.projector.power_off();
  fixture.pass(50ms);
  const TimePoint off_at = fixture.clock.now();
  CHECK(fixture.answer_to_power_on() == ProjectorReply::Ok);
  CHECK(fixture.is_on);
  const auto on = std::ranges::find(fixture.channel.sent, "~0000 1\r", &ScriptedChannel::Sent::message);
  REQUIRE(on != fixture.channel.sent.end());
  CHECK(on->at - off_at >= 60s);
  CHECK(on->at - off_at < 61s);  // a gap and a reply
}

TEST_CASE("a power off that waits for a question to be answered is sent when light off drops the question") {
  SerialProjectorFixture fixture(text_table(false));
  fixture.power_on();
  fixture.fall_silent();
  fixture.projector.power_off();
  fixture.pass(8s);  // three tries of a second; 5 s later power off is sent again
  REQUIRE(fixture.is_on);
  fixture.projector.ask_status([](const ProjectorStatus&) {});
  fixture.pass(500ms);
  fixture.behave_again();
  fixture.projector.light_off();
  fixture.pass(2s);
  CHECK_FALSE(fixture.is_on);
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a projector that still cools down from before the program ran is turned on again and again") {
  deaf_until = clock.now() + 50s;
  CHECK(answer_to_power_on() == ProjectorReply::Ok);
  CHECK(is_on);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector that never comes on is given up in less than the time a print waits for it") {
  deaf_until = TimePoint::max();
  CHECK(answer_to_power_on() == ProjectorReply::Refused);
  CHECK(projector.last_problem() ==
        "the projector at /dev/ttyUSB7 says that it is off, long after it was turned on");
  CHECK(now() < 300s);  // the print process's deadline
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "power off follows a light off that is never confirmed, and ends the light that way") {
  power_on();
  light_on();
  channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r") behave(message);
  };
  projector.power_off();
  pass(10s);
  CHECK_FALSE(is_on);
  REQUIRE(events.size() == 2);
  CHECK(events[1].kind == MachineEvent::Kind::Recovery);
  channel.sent.clear();
  projector.light_off();
  pass(60s);
  CHECK(channel.sent.empty());  // off is dark
}

TEST_CASE_METHOD(SerialProjectorFixture, "power off comes soon once light off is known to be ignored") {
  power_on();
  light_on();
  fall_silent();
  projector.light_off();
  pass(10s);
  REQUIRE(events.size() == 1);
  channel.sent.clear();
  const TimePoint asked = clock.now();
  projector.power_off();
  pass(10s);
  REQUIRE(channel.sent.size() > 2);
  CHECK(channel.sent[0].message == "~0002 1\r");
  CHECK(channel.sent[1].message == "~0000 0\r");
  CHECK(channel.sent[1].at - asked < 1200ms);  // one try of light off
}

TEST_CASE_METHOD(SerialProjectorFixture, "light off does not cancel a pending power off") {
  power_on();
  light_on();
  projector.power_off();
  projector.light_off();
  pass(5s);
  CHECK_FALSE(is_on);
  CHECK_FALSE(light);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a message that a projector sends by itself is a machine event if it matters") {
  power_on();
  channel.send("INFO1\r");
  pass(1s);
  CHECK(events.empty());
  channel.send("INFO4\r");
  pass(1s);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(events[0].what == "the projector at /dev/ttyUSB7 says: the lamp failed");
  channel.send("INFO2\r");
  pass(1s);
  CHECK(events.size() == 2);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector that cools down because it was told to causes no machine event") {
  power_on();
  projector.power_off();
  pass(1s);
  channel.send("INFO2\r");
  pass(1s);
  CHECK(events.empty());
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a line of the projector's own between a command and its reply is not taken for the reply") {
  power_on();
  pass(1s);
  answer_always("INFO1\rP\r");
  CHECK(answer_to_light_on() == ProjectorReply::Ok);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a serial line that is lost is a fault, and every command is answered at once") {
  power_on();
  pass(1s);
  start_light_on();
  const TimePoint unplugged = clock.now();
  channel.unplug();
  wait_for_answer();
  CHECK(answer == ProjectorReply::NoAnswer);
  CHECK(answered_at == unplugged);
  projector.light_off();
  pass(60s);
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == MachineEvent::Kind::Fault);
  CHECK(events[0].what ==
        "the serial port /dev/ttyUSB7 was lost: it was unplugged; the projector's light may be on");
  CHECK(answer_to_power_on() == ProjectorReply::NoAnswer);
  CHECK(projector.last_problem() ==
        "the projector at /dev/ttyUSB7 cannot be reached: the serial line is lost");
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector's status is its power and its lamp hours, and asking changes nothing") {
  std::optional<ProjectorStatus> status;
  const auto ask = [&] {
    status.reset();
    projector.ask_status([&](const ProjectorStatus& s) { status = s; });
    pass(10s);
    REQUIRE(status);
  };
  ask();
  CHECK(status->powered == false);
  CHECK_FALSE(status->lamp_hours);
  is_on = true;
  ask();
  CHECK(status->reply == ProjectorReply::Ok);
  CHECK(status->powered == true);
  CHECK(status->lamp_hours == 1234);
  CHECK(channel.messages() == Messages{"~00124 1\r", "~00124 1\r", "~00108 1\r"});
  fall_silent();
  ask();
  CHECK(status->reply == ProjectorReply::NoAnswer);
  CHECK(status->problem ==
        "the projector at /dev/ttyUSB7 did not answer \"power\" in 3 tries of 1000 ms: is it connected, and "
        "set to 9600 "
        "baud?");
}

TEST_CASE("a projector's brightness is set when it is warm and dark") {
  VirtualClock clock;
  ScriptedChannel channel{clock};
  ProjectorTable table = text_table();
  table.power.reset();
  table.brightness =
      BrightnessCommand{.command = text_command("brightness", "CM+LEDS=", {{ReplyMeaning::Accepted, "OK"}}),
                        .number_at = 8,
                        .least = 91,
                        .most = 1023};
  channel.projector = [&](const std::string& message) {
    channel.send(message.starts_with("CM") ? "OK\r" : "P\r");
  };
  SerialProjector projector(channel, clock, table, 440);
  std::optional<ProjectorReply> answer;
  projector.power_on([&](ProjectorReply r) { answer = r; });
  while (!answer && clock.run_next()) {
  }
  CHECK(answer == ProjectorReply::Ok);
  CHECK(channel.messages() == Messages{"~0000 1\r", "~0002 1\r", "~0002 1\r", "CM+LEDS=440\r"});
}

TEST_CASE("a table without a light has its projector shine as long as it is on") {
  SerialProjectorFixture fixture(text_table(false));
  fixture.power_on();
  CHECK(fixture.answer_to_light_on() == ProjectorReply::Ok);
  fixture.projector.light_off();
  fixture.pass(4s);
  CHECK(fixture.channel.sent.empty());
  CHECK(fixture.events.empty());
}

TEST_CASE("a serial projector's destructor sends an unconfirmed light off, or power off, once more") {
  VirtualClock clock;
  ScriptedChannel channel{clock};
  {
    SerialProjector projector(channel, clock, text_table());
    projector.light_off();
    projector.power_off();
  }
  CHECK(channel.messages() == Messages{"~0002 1\r"});
  CHECK(channel.last_words == Messages{"~0002 1\r", "~0000 0\r"});
}

namespace {

// A projector that obeys power on at once, with its light, and takes no other command before it is warm.
struct SlowStarter : SerialProjectorFixture {
  explicit SlowStarter(Duration warm_after, const std::string& until_then,
                       ProjectorTable table = text_table())
      : SerialProjectorFixture(std::move(table)) {
    channel.projector = [this, warm_after, until_then](const std::string& message) {
      if (message == "~0000 1\r" && !is_on) {
        is_on = light = true;
        on_at = clock.now();
        if (!answers_power_on) return;
      } else if (is_on && clock.now() - on_at < warm_after) {
        if (!until_then.empty()) channel.send(until_then, reply);
        return;
      }
      behave(message);
    };
  }
  bool answers_power_on = true;
  TimePoint on_at{};
};

}  // namespace

TEST_CASE("a projector that obeys power on without an answer is made dark and turned off") {
  SlowStarter fixture(15s, "");
  fixture.answers_power_on = false;
  CHECK(fixture.answer_to_power_on() == ProjectorReply::NoAnswer);
  fixture.projector.light_off();
  fixture.projector.power_off();
  fixture.pass(60s);
  CHECK_FALSE(fixture.light);
  CHECK_FALSE(fixture.is_on);
}

TEST_CASE("light off between power on and its reply is repeated until the projector comes up and takes it") {
  SlowStarter fixture(20s, "F\r");
  fixture.reply = 300ms;
  fixture.start_power_on();
  while (!fixture.is_on)
    REQUIRE(fixture.clock.run_next());
  fixture.pass(100ms);
  fixture.projector.light_off();
  fixture.pass(35s);
  CHECK_FALSE(fixture.light);
  CHECK(fixture.events.empty());
}

TEST_CASE_METHOD(
    SerialProjectorFixture,
    "a print cancelled in a warm-up ends with lamp and light off, whatever is refused and said until then") {
  std::optional<TimePoint> on_at;
  channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r") on_at = clock.now(), light = true;
    const bool cold = on_at && clock.now() - *on_at < 20s;
    if (cold && message == "~00124 1\r") return channel.send("OK0\r");
    if (cold && message != "~0000 1\r") return channel.send("F\r");
    behave(message);
  };
  start_power_on();
  while (!on_at)
    REQUIRE(clock.run_next());
  pass(5s);
  projector.light_off();
  projector.power_off();
  pass(60s);
  CHECK_FALSE(light);
  CHECK_FALSE(is_on);
  CHECK(events.empty());
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "power on that is refused by a projector that is off does not count as light") {
  channel.projector = [&](const std::string& message) {
    if (message == "~00124 1\r") return channel.send("OK0\r");
    channel.send("F\r");
  };
  CHECK(answer_to_power_on() == ProjectorReply::Refused);
  projector.light_off();
  projector.power_off();
  pass(120s);
  CHECK(projector.light_off_unconfirmed().empty());
  CHECK(events.empty());
  channel.sent.clear();
  pass(600s);
  CHECK(channel.sent.empty());
}

TEST_CASE("a warm-up that was interrupted is waited for to its end") {
  for (const bool switches_light : {true, false}) {
    for (const bool asks : {true, false}) {
      ProjectorTable table = text_table(switches_light);
      if (!asks) table.power.reset();
      SerialProjectorFixture fixture(table);
      fixture.start_power_on();
      while (!fixture.is_on)
        REQUIRE(fixture.clock.run_next());
      const TimePoint on_at = fixture.clock.now();
      fixture.pass(2s);
      fixture.projector.light_off();
      fixture.pass(3s);
      CHECK(fixture.answer_to_power_on() == ProjectorReply::Ok);
      CHECK(fixture.answered_at - on_at >= 30s);
      CHECK(fixture.answered_at - on_at < 32s);
    }
  }
}

TEST_CASE("power off is repeated until the projector confirms it or says that it is off") {
  for (const std::string& answer : {std::string("F\r"), std::string()}) {
    SerialProjectorFixture fixture;
    fixture.power_on();
    bool takes = false;
    fixture.channel.projector = [&](const std::string& message) {
      if (message != "~0000 0\r" || takes) return fixture.behave(message);
      if (!answer.empty()) fixture.channel.send(answer);
    };
    fixture.projector.power_off();
    fixture.pass(25s);
    CHECK(fixture.is_on);
    CHECK(fixture.events.empty());
    fixture.pass(20s);
    REQUIRE(fixture.events.size() == 1);
    CHECK(fixture.events[0].kind == MachineEvent::Kind::Fault);
    CHECK(fixture.events[0].what.starts_with("the lamp may be on: the projector at /dev/ttyUSB7 "));
    CHECK(fixture.events[0].what.find("\"power off\"") != std::string::npos);
    takes = true;
    fixture.pass(65s);
    CHECK_FALSE(fixture.is_on);
    CHECK(fixture.events.size() == 1);
    fixture.channel.sent.clear();
    fixture.pass(600s);
    CHECK(fixture.channel.sent.empty());
  }
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a print that begins while power off is not yet confirmed does not lose its power later") {
  power_on();
  refuse("~0000 0\r");
  projector.power_off();
  pass(12s);
  behave_again();
  power_on();
  pass(120s);
  CHECK(is_on);
}

TEST_CASE("a projector that falls silent or turns itself off in a print is a fault, reported once") {
  for (const bool switches_light : {true, false}) {
    for (const bool silent : {true, false}) {
      SerialProjectorFixture fixture(text_table(switches_light));
      fixture.power_on();
      fixture.pass(60s);
      CHECK(fixture.events.empty());
      fixture.is_on = false;
      if (silent) fixture.fall_silent();
      // As in a print without light commands: light off comes in between, and nothing is asked.
      for (int layer = 0; layer < 20; ++layer) {
        if (!switches_light) fixture.projector.light_off();
        fixture.pass(1s);
      }
      REQUIRE(fixture.events.size() == 1);
      CHECK(fixture.events[0].kind == MachineEvent::Kind::Fault);
      CHECK(fixture.events[0].what ==
            (silent ? "the projector at /dev/ttyUSB7 did not answer \"power\" in 3 tries of 1000 ms: is it "
                      "connected, and set to 9600 baud?"
                    : "the projector at /dev/ttyUSB7 says that it is off, although it was not turned off"));
      fixture.pass(60s);
      CHECK(fixture.events.size() == 1);
    }
  }
}

TEST_CASE("a projector that a crashed process has left on is turned off, unless a print has begun") {
  for (const bool prints : {false, true}) {
    SerialProjectorFixture fixture;
    fixture.is_on = fixture.light = true;
    fixture.projector.power_off_if_on();
    fixture.projector.light_off();
    if (prints) fixture.start_power_on();
    fixture.pass(30s);
    CHECK(fixture.is_on == prints);
    CHECK_FALSE(fixture.light);
    if (prints) CHECK(fixture.answer == ProjectorReply::Ok);
  }
  SerialProjectorFixture off;
  off.projector.power_off_if_on();
  off.pass(30s);
  CHECK(off.channel.messages() == Messages{"~00124 1\r"});
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector that was left on and is silent at first is turned off when it answers") {
  is_on = true;
  fall_silent();
  projector.power_off_if_on();
  pass(20s);
  behave_again();
  pass(60s);
  CHECK_FALSE(is_on);
  channel.sent.clear();
  pass(5min);
  CHECK(channel.sent.empty());
}

TEST_CASE(
    "a projector that may be warming up is not believed when it refuses light off and says that it is off") {
  for (const bool may_warm_up : {true, false}) {
    CAPTURE(may_warm_up);
    SerialProjectorFixture fixture;
    fixture.channel.projector = [&](const std::string& message) {
      // The projector calls itself on, and obeys light off, once it is warm; then it has a picture of its
      // own.
      const bool warm = fixture.clock.now() >= TimePoint{} + 10s;
      if (warm && !fixture.is_on) fixture.is_on = fixture.light = true;
      if (message == "~0002 1\r" && !warm) return fixture.channel.send("F\r");
      fixture.behave(message);
    };
    std::optional<ProjectorReply> dark;
    if (may_warm_up) fixture.projector.may_warm_up();
    fixture.projector.confirm_dark([&](ProjectorReply reply) { dark = reply; });
    fixture.pass(9s);
    CHECK(dark.has_value() == !may_warm_up);
    fixture.pass(6s);
    REQUIRE(dark == ProjectorReply::Ok);
    CHECK(fixture.light == false);
  }
}

TEST_CASE("a projector that warms up is not dark because it says that it is off") {
  ProjectorTable table = text_table();
  table.warm_up = 5s;
  SerialProjectorFixture fixture(table);
  std::optional<TimePoint> warm_at;
  const auto is_warm = [&] { return warm_at && fixture.clock.now() >= *warm_at; };
  fixture.channel.projector = [&](const std::string& message) {
    // The first answers come as late as may be, so that light off is under way when power on is due.
    if (message == "~00124 1\r")
      return fixture.channel.send(is_warm() ? "OK1\r" : "OK0\r", warm_at ? 20ms : 1990ms);
    if (message == "~0000 1\r") warm_at = fixture.clock.now() + 4900ms;
    if (message == "~0002 1\r") {
      if (!is_warm()) return;
      fixture.light = true;
    }
    fixture.channel.send("P\r");
  };
  fixture.projector.may_warm_up();
  fixture.projector.light_off();
  fixture.start_power_on();
  while (!fixture.answer) {
    fixture.clock.run_next();
    const bool has_a_picture = is_warm() && !fixture.light;
    if (has_a_picture) CHECK_FALSE(fixture.projector.light_off_unconfirmed().empty());
  }
  CHECK(fixture.answer == ProjectorReply::Ok);
}

TEST_CASE_METHOD(SerialProjectorFixture,
                 "a projector that comes on while it may be warming up is turned off") {
  const auto warm = clock.call_after(12s, [&] { is_on = true; });
  projector.may_warm_up();
  projector.power_off_if_on();
  pass(11s);
  CHECK(times_sent("~0000 0\r") == 0);
  pass(10s);
  CHECK(times_sent("~0000 0\r") == 1);
  CHECK_FALSE(is_on);
  channel.sent.clear();
  pass(60s);
  CHECK(channel.sent.empty());
}
