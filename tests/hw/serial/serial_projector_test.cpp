#include "hw/serial/serial_projector.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/serial/projector_tables.hpp"
#include "tests/hw/serial/scripted_channel.hpp"

using namespace contourd;
using namespace contourd::testing;
using namespace std::chrono_literals;

namespace {

using Messages = std::vector<std::string>;

// A projector of the text table that behaves, with the messages that it gets and the results of the calls.
struct Bench {
  explicit Bench(ProjectorTable table = text_table()) : projector(channel, clock, std::move(table)) {
    channel.projector = [this](const std::string& message) { behave(message); };
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
  void answer_always(const std::string& bytes) {
    channel.projector = [this, bytes](const std::string&) { channel.send(bytes, reply); };
  }

  void pass(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over)
      clock.run_next();
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
  void power_on() {
    start_power_on();
    wait_for_answer();
    REQUIRE(answer == ProjectorReply::Ok);
    channel.sent.clear();
  }
  void light_on() {
    start_light_on();
    wait_for_answer();
    REQUIRE(answer == ProjectorReply::Ok);
    channel.sent.clear();
  }
  [[nodiscard]] std::ptrdiff_t times_sent(const std::string& message) const {
    return std::ranges::count(channel.sent, message, &ScriptedChannel::Sent::message);
  }
  [[nodiscard]] Duration now() const { return clock.now().time_since_epoch(); }

  VirtualClock clock;
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

TEST_CASE("a serial projector that is off is turned on, warmed up, asked again and made dark") {
  Bench bench;
  bench.light = true;  // as the projector comes up
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.channel.messages() ==
        Messages{"~00124 1\r", "~0000 1\r", "~0002 1\r", "~00124 1\r", "~0002 1\r"});
  CHECK_FALSE(bench.light);
  CHECK(bench.now() >= 30s);
  CHECK(bench.now() < 31s);  // four commands and their gaps beside the warm-up
}

TEST_CASE("a projector that refuses light off while it warms up gets it again and again after power on") {
  Bench bench;
  std::optional<TimePoint> on_at;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r") on_at = bench.clock.now(), bench.light = true;  // with a start-up picture
    if (message == "~0002 1\r" && bench.clock.now() - *on_at < 25s) return bench.channel.send("F\r");
    bench.behave(message);
  };
  bench.start_power_on();
  bench.pass(20s);
  REQUIRE(bench.channel.sent.size() > 12);  // a second between attempts, and a reply and a gap
  CHECK(bench.channel.sent[2].message == "~0002 1\r");
  CHECK(bench.channel.sent[2].at - *on_at < 200ms);  // power on's reply after 20 ms, and the gap of 100 ms
  CHECK(bench.light);
  bench.pass(7s);
  CHECK_FALSE(bench.light);
  CHECK_FALSE(bench.answer);  // the projector is not warm yet
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.events.empty());
}

TEST_CASE("a projector that is deaf while it warms up is made dark after that, without a machine event") {
  Bench bench;
  std::optional<TimePoint> on_at;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r" && !on_at) on_at = bench.clock.now(), bench.light = bench.is_on = true;
    if (on_at && message != "~0000 1\r" && bench.clock.now() - *on_at < 29900ms) return;
    bench.behave(message);
  };
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK_FALSE(bench.light);
  CHECK(bench.events.empty());
}

TEST_CASE("a projector that refuses light off when it is warm is reported") {
  Bench bench;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") return bench.channel.send("F\r");
    bench.behave(message);
  };
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  CHECK(bench.now() >= 30s);
  CHECK(bench.now() < 33s);  // an attempt a second
  CHECK(bench.events.size() == 1);
}

TEST_CASE("a projector that warms up a second time can be turned off") {
  Bench bench;
  bench.power_on();
  bench.projector.power_off();
  bench.pass(70s);
  REQUIRE_FALSE(bench.is_on);
  bench.start_power_on();
  bench.pass(10s);
  REQUIRE(bench.is_on);
  bench.light = true;
  bench.projector.power_off();
  bench.pass(5s);
  CHECK_FALSE(bench.is_on);
  CHECK_FALSE(bench.light);
  CHECK_FALSE(bench.answer);
}

TEST_CASE("a serial projector that is on already is not warmed up again") {
  Bench bench;
  bench.is_on = bench.light = true;
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.channel.messages() == Messages{"~00124 1\r", "~0002 1\r"});
  CHECK(bench.now() < 1s);
  CHECK_FALSE(bench.light);
}

TEST_CASE("light on is reported when the serial projector's reply has come") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  const TimePoint asked = bench.clock.now();
  bench.light_on();
  CHECK(bench.light);
  CHECK(bench.answered_at - asked == 20ms);
}

TEST_CASE("light off is sent in the very call, ahead of a light on that waits for its reply") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.reply = 500ms;
  bench.start_light_on();
  bench.pass(200ms);
  bench.channel.sent.clear();
  const TimePoint asked = bench.clock.now();
  bench.projector.light_off();
  REQUIRE(bench.channel.sent.size() == 1);
  CHECK(bench.channel.sent[0].message == "~0002 1\r");
  CHECK(bench.channel.sent[0].at == asked);
  bench.pass(5s);
  CHECK_FALSE(bench.answer);  // dropped
  CHECK(bench.events.empty());
  CHECK_FALSE(bench.light);
}

TEST_CASE("light off waits only for the gap that the projector needs after a command") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.reply = 500ms;
  bench.start_light_on();
  const TimePoint asked = bench.clock.now();
  bench.projector.light_off();
  bench.pass(1s);
  REQUIRE(bench.channel.sent.size() >= 2);  // and again when light on's reply has come
  // 8 bytes of 10 bits at 9600 baud are 8.333 ms.
  CHECK(bench.channel.sent[1].at - asked == 100ms + std::chrono::nanoseconds{8'333'333});
}

TEST_CASE("the late reply to a light on does not confirm the light off after it") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 0\r") bench.channel.send("P\r", 300ms);  // and light off is lost
  };
  bench.start_light_on();
  bench.pass(200ms);
  bench.projector.light_off();
  bench.pass(10s);
  CHECK(bench.events.size() == 1);
  CHECK(bench.channel.sent.size() > 4);
}

TEST_CASE("a reply to light on that comes late and twice does not confirm the light off after it") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  int light_offs = 0;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r" && ++light_offs == 1) return;  // lost
    if (message != "~0002 0\r") return bench.behave(message);
    bench.light = true;
    bench.channel.send("P\rP\r", 300ms);
  };
  bench.start_light_on();
  bench.pass(200ms);
  bool dark = false;
  bench.projector.light_off();
  bench.projector.when_dark([&] { dark = true; });
  bench.pass(110ms);
  CHECK(bench.light);
  CHECK_FALSE(dark);
  // The gap of 100 ms, the reply's 20 ms.
  bench.pass(125ms);
  CHECK_FALSE(bench.light);
  CHECK(dark);
}

TEST_CASE("a reply to light off that comes late and twice does not confirm the power off after it") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  int light_offs = 0, power_offs = 0;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r" && ++power_offs == 1) return;  // lost
    if (message != "~0002 1\r") return bench.behave(message);
    // The first two light offs are both answered, and the second one's reply comes twice.
    ++light_offs == 1 ? bench.channel.send("P\r", 1100ms) : bench.channel.send("P\rP\r", 200ms);
  };
  bench.projector.power_off();
  bench.pass(1300ms);
  REQUIRE(power_offs == 1);
  bench.pass(500ms);
  CHECK(power_offs == 3);  // the second power off's reply might be light off's third
  CHECK_FALSE(bench.is_on);
}

TEST_CASE(
    "light off is repeated until the projector confirms it, and reported once when that takes too long") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.fall_silent();
  bench.projector.light_off();
  bench.pass(2900ms);
  CHECK(bench.events.empty());
  bench.pass(300ms);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(bench.events[0].what ==
        "the light may be on: the projector at /dev/ttyUSB7 did not answer \"light off\" in 3 tries of 1000 "
        "ms: is it "
        "connected, and set to 9600 baud?");
  bench.pass(60s);
  CHECK(bench.channel.sent.size() > 15);
  for (const std::string& message : bench.channel.messages())
    CHECK(message == "~0002 1\r");
  CHECK(bench.events.size() == 1);

  CHECK_FALSE(bench.projector.why_not_ready().empty());
  CHECK(bench.projector.light_off_unconfirmed().find("did not answer \"light off\"") != std::string::npos);

  bench.channel.projector = [&](const std::string& message) { bench.behave(message); };
  bench.pass(2s);
  CHECK_FALSE(bench.light);
  CHECK(bench.projector.why_not_ready().empty());
  CHECK(bench.projector.light_off_unconfirmed().empty());
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].kind == MachineEvent::Kind::Recovery);
  CHECK(bench.events[1].what == "the projector at /dev/ttyUSB7 has confirmed that its light is off");
  bench.channel.sent.clear();
  bench.pass(60s);
  for (const std::string& message : bench.channel.messages())
    CHECK(message == "~00124 1\r");  // the question whether it is still on
}

TEST_CASE("the reason why the light may be on is still reported after another command has failed") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") return bench.channel.send("F\r");
    if (message != "~0000 0\r") bench.behave(message);
  };
  bench.projector.power_off();
  for (int second = 0; second < 20; ++second) {
    bench.pass(1s);
    CHECK_FALSE(bench.projector.light_off_unconfirmed().empty());
    CHECK(bench.projector.light_off_unconfirmed().find("power off") == std::string::npos);
  }
  CHECK_FALSE(bench.projector.why_not_ready().empty());
}

TEST_CASE("a light is not turned on again while its light off is not confirmed") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.fall_silent();
  bench.projector.light_off();
  bench.pass(4s);
  bench.channel.sent.clear();
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  bench.pass(10s);
  for (const std::string& message : bench.channel.messages())
    CHECK(message == "~0002 1\r");
}

TEST_CASE("light on that is not confirmed is followed by light off") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") bench.behave(message);
    if (message == "~0002 0\r") bench.light = true;  // obeyed, but not answered
  };
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(bench.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"light on\" in 1 try of 1000 ms: is it connected, "
        "and set to 9600 baud?");
  bench.pass(3s);
  CHECK(bench.times_sent("~0002 0\r") == 1);
  CHECK_FALSE(bench.light);
}

TEST_CASE("a projector that is silent from the start is asked whether it is on, without a machine event") {
  Bench bench;
  bench.fall_silent();
  bench.projector.light_off();
  CHECK(bench.channel.messages() == Messages{"~0002 1\r"});
  bench.pass(60s);
  CHECK(bench.channel.messages() ==
        Messages{"~0002 1\r", "~0002 1\r", "~0002 1\r", "~00124 1\r", "~00124 1\r", "~00124 1\r"});
  CHECK(bench.events.empty());
}

TEST_CASE("a projector that is off and refuses light off is dark") {
  Bench bench;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0002 1\r") return bench.channel.send("F\r");  // as Optoma's do in standby
    bench.behave(message);
  };
  bench.projector.light_off();
  bench.pass(60s);
  CHECK(bench.channel.messages() == Messages{"~0002 1\r", "~00124 1\r"});
  CHECK(bench.events.empty());
}

TEST_CASE(
    "a projector found on that does not confirm light off is reported once, and gets it again and again") {
  Bench bench;
  bench.is_on = bench.light = true;
  bool hears = false;
  bench.channel.projector = [&](const std::string& message) {
    if (hears || message != "~0002 1\r") bench.behave(message);
  };
  bench.projector.light_off();
  bench.pass(60s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(bench.events[0].what.starts_with(
      "the light may be on: the projector at /dev/ttyUSB7 did not answer \"light off\""));
  CHECK(bench.channel.sent.size() > 15);
  hears = true;
  bench.pass(2s);
  CHECK_FALSE(bench.light);
  bench.channel.sent.clear();
  bench.pass(60s);
  CHECK(bench.channel.sent.empty());
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].kind == MachineEvent::Kind::Recovery);
}

TEST_CASE("garbage in answer to the first light off is reported once") {
  Bench bench;
  bench.answer_always("\x8f\xe0\x03\xff");
  bench.projector.light_off();
  bench.pass(60s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(
      bench.events[0].what.starts_with("the light may be on: the projector at /dev/ttyUSB7 answered "
                                       "\"light off\" in 3 tries of 1000 ms with \""));
}

TEST_CASE("confirm_dark answers when the projector has confirmed, or was asked often enough") {
  const auto reply_of = [](Bench& bench) {
    std::optional<ProjectorReply> reply;
    bench.projector.confirm_dark([&](ProjectorReply r) { reply = r; });
    CHECK_FALSE(reply);
    bench.pass(30s);
    REQUIRE(reply);
    return *reply;
  };
  {
    Bench on;
    on.is_on = on.light = true;
    CHECK(reply_of(on) == ProjectorReply::Ok);
    CHECK(on.channel.messages() == Messages{"~0002 1\r"});
    CHECK_FALSE(on.light);
  }
  {
    Bench standby;
    standby.channel.projector = [&](const std::string& message) {
      standby.channel.send(message == "~00124 1\r" ? "OK0\r" : "F\r");
    };
    CHECK(reply_of(standby) == ProjectorReply::Ok);
  }
  {
    Bench refuses;
    refuses.channel.projector = [&](const std::string& message) {
      refuses.channel.send(message == "~00124 1\r" ? "OK1\r" : "F\r");
    };
    CHECK(reply_of(refuses) == ProjectorReply::Refused);
    CHECK(refuses.projector.last_problem() ==
          "the projector at /dev/ttyUSB7 refused \"light off\": it answered \"F\"");
  }
  {
    Bench silent;
    silent.fall_silent();
    CHECK(reply_of(silent) == ProjectorReply::NoAnswer);
    CHECK(
        silent.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"light off\" in 3 tries of 1000 ms: is it connected, "
        "and set to 9600 baud?");
  }
  {
    Bench garbled;
    garbled.answer_always("\x8f\xe0");
    CHECK(reply_of(garbled) == ProjectorReply::NoAnswer);
  }
  {
    Bench lost;
    lost.channel.unplug();
    CHECK(reply_of(lost) == ProjectorReply::NoAnswer);
  }
  {
    // The part of a table that --light-off knows.
    ProjectorTable table = text_table();
    table.light_on.reset();
    table.power.reset();
    Bench partial(table);
    partial.fall_silent();
    CHECK(reply_of(partial) == ProjectorReply::NoAnswer);
    CHECK(partial.channel.messages() == Messages{"~0002 1\r", "~0002 1\r", "~0002 1\r"});
  }
}

TEST_CASE("a print that begins while the light is not yet known to be off gets its answer") {
  Bench bench;
  bench.is_on = bench.light = true;
  bool hears = false;
  bench.channel.projector = [&](const std::string& message) {
    if (hears || message != "~0002 1\r") bench.behave(message);
  };
  bench.projector.light_off();
  bench.start_power_on();
  bench.pass(20s);
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(bench.events.size() == 1);
}

TEST_CASE("a silent projector is asked again as often as its table says, then given up") {
  Bench bench;
  bench.fall_silent();
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(bench.channel.messages() ==
        Messages{"~00124 1\r", "~00124 1\r", "~00124 1\r", "~0000 1\r", "~0000 1\r", "~0000 1\r"});
  CHECK(bench.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 did not answer \"power on\" in 3 tries of 1000 ms: is it connected, "
        "and set to 9600 "
        "baud?");
}

TEST_CASE("a projector that ignores questions while it is off is turned on all the same") {
  Bench bench;
  bench.channel.projector = [&](const std::string& message) {
    if (bench.is_on || message == "~0000 1\r") bench.behave(message);
  };
  bench.power_on();
  CHECK(bench.is_on);
}

TEST_CASE("garbage, as from a wrong baud rate, is shown in the message") {
  Bench bench;
  bench.answer_always("\x8f\xe0\x03\xff");
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(
      bench.projector.last_problem() ==
      "the projector at /dev/ttyUSB7 answered \"power on\" in 3 tries of 1000 ms with "
      "\"\\x8F\\xE0\\x03\\xFF\\x8F\\xE0\\x03\\xFF\\x8F\\xE0\\x03\\xFF\", which is not a reply to it: is its "
      "baud rate 9600, and is the table \"Optoma\" the right one for it?");
}

TEST_CASE("a refusal is distinguished from silence, and its bytes are shown") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.channel.projector = [&](const std::string& message) {
    bench.channel.send(message == "~0002 0\r" ? "F\r" : "P\r");
  };
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  CHECK(bench.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 refused \"light on\": it answered \"F\"");
}

TEST_CASE("a reply without its line end counts when nothing more has come in time") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.answer_always("P");
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.channel.sent.size() == 1);
}

TEST_CASE(
    "a reply that comes after a command was sent again answers it, and its repetition answers no other") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.reply = 1100ms;  // the table's timeout is 1 s
  const TimePoint start = bench.clock.now();
  bench.answer.reset();
  bench.projector.ask_status([&](const ProjectorStatus& status) {
    if (!bench.answer) bench.answer = status.reply, bench.answered_at = bench.clock.now();
  });
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.channel.messages() == Messages{"~00124 1\r", "~00124 1\r", "~00108 1\r", "~00108 1\r"});
  CHECK(bench.answered_at - start == 2 * 1100ms + 100ms);  // with the gap between the two questions
  // The second reply is still on its way when light off, which is lost, waits for its own.
  bench.fall_silent();
  bench.projector.light_off();
  bench.pass(5s);
  CHECK(bench.events.empty());  // no light was ever asked for
  CHECK(bench.channel.messages().back() != "~0002 0\r");
}

TEST_CASE("light on is sent once, and the light counts from its first byte, whatever the reply does") {
  for (const bool obeys : {true, false}) {
    CAPTURE(obeys);
    Bench bench;
    bench.power_on();
    bench.pass(1s);
    bench.channel.projector = [&](const std::string& message) {
      if (message != "~0002 0\r") return bench.behave(message);
      bench.light = obeys;  // and the reply is lost
    };
    const TimePoint asked = bench.clock.now();
    bench.start_light_on();
    bench.wait_for_answer();
    CHECK(bench.sent_at == asked);
    CHECK(bench.answer == ProjectorReply::NoAnswer);
    bench.pass(3s);
    const auto light = bench.projector.last_light();
    REQUIRE(light);
    CHECK(light->on_earliest == asked);
    CHECK_FALSE(light->on_latest);
    // The reply was waited for during a second from the command's last byte, then light off was sent. The
    // first reply may be light on's and the second a repetition of it, so the third counts; each takes a gap
    // of 100 ms and a reply of 20 ms.
    CHECK(light->most(bench.clock.now()) > 1240ms);
    CHECK(light->most(bench.clock.now()) < 1300ms);
    CHECK(light->least() == Duration{0});
    CHECK(bench.times_sent("~0002 0\r") == 1);
  }
}

TEST_CASE("a light that comes no sooner than its projector's latency counts from then on") {
  ProjectorTable table = text_table();
  table.latency = 150ms;
  Bench bench(table);
  bench.power_on();
  bench.pass(1s);
  const TimePoint asked = bench.clock.now();
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.sent_at == asked + 150ms);
}

TEST_CASE("after a lost reply to light on the projector is asked, where it can be, whether the light is on") {
  ProjectorTable table = text_table();
  table.light = text_command("light", "~00355 1", {{ReplyMeaning::On, "OK0"}, {ReplyMeaning::Off, "OK1"}});
  for (const bool obeyed : {true, false}) {
    CAPTURE(obeyed);
    Bench bench(table);
    bench.power_on();
    bench.pass(1s);
    bench.channel.projector = [&](const std::string& message) {
      if (message == "~00355 1\r") return bench.channel.send(bench.light ? "OK0\r" : "OK1\r");
      if (message != "~0002 0\r") return bench.behave(message);
      bench.light = obeyed;
    };
    bench.start_light_on();
    bench.wait_for_answer();
    CHECK(bench.answer == (obeyed ? ProjectorReply::Ok : ProjectorReply::NoAnswer));
    CHECK(bench.projector.last_light()->on_latest.has_value() == obeyed);
    bench.pass(3s);
    CHECK(bench.light == obeyed);
    // Light off is sent although light on was not obeyed.
    CHECK((bench.times_sent("~0002 1\r") > 0) == !obeyed);
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
      Bench bench(table);
      bench.power_on();
      bench.light_on();
      bench.channel.projector = [&](const std::string& message) {
        if (message == "~00355 1\r") return bench.channel.send(bench.light ? "OK0\r" : "OK1\r");
        bench.light = message == "~0002 0\r" && obeyed;
        // The second light off is answered for both of them; light on's reply looks like one more of these.
        if (message == "~0002 0\r") return bench.channel.send("P\r");
        if (bench.times_sent("~0002 1\r") == 2) bench.channel.send("P\rP\r");
      };
      bench.projector.light_off();
      bench.pass(1500ms);
      REQUIRE(bench.projector.light_off_unconfirmed().empty());
      bench.start_light_on();
      bench.wait_for_answer();
      CHECK(bench.answer == (asked && !obeyed ? ProjectorReply::NoAnswer : ProjectorReply::Ok));
      CHECK(bench.projector.last_light()->on_latest.has_value() == (asked && obeyed));
      if (asked && !obeyed)
        CHECK(bench.projector.last_problem().find("has not confirmed that its light is on") !=
              std::string::npos);
    }
  }
}

TEST_CASE("the callback of when_dark is called when light off is confirmed, not before") {
  Bench bench;
  bench.power_on();
  std::optional<TimePoint> dark_at;
  const auto wait = [&] {
    dark_at.reset();
    bench.projector.when_dark([&] { dark_at = bench.clock.now(); });
    CHECK_FALSE(dark_at);
  };
  wait();
  bench.pass(1s);
  CHECK(dark_at);  // dark from the start
  bench.light_on();
  wait();
  bench.pass(1s);
  CHECK_FALSE(dark_at);
  bench.fall_silent();
  const TimePoint off = bench.clock.now();
  bench.projector.light_off();
  bench.pass(2500ms);
  CHECK_FALSE(dark_at);
  bench.channel.projector = [&](const std::string& message) { bench.behave(message); };
  bench.pass(2s);
  REQUIRE(dark_at);
  CHECK_FALSE(bench.light);
  CHECK(bench.projector.last_light()->off_earliest == off);
  CHECK(bench.projector.last_light()->off_latest == dark_at);
  wait();
  bench.start_light_on();  // drops the wait for darkness
  bench.pass(1s);
  CHECK_FALSE(dark_at);
}

TEST_CASE("a light on is refused while a light off is not confirmed") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.projector.light_off();
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  CHECK_FALSE(bench.sent_at);
  bench.pass(1s);
  bench.light_on();
  CHECK(bench.light);
}

TEST_CASE("a projector is not asked whether it is still on if light off would have to wait for the answer") {
  Bench bench;
  bench.power_on();
  bench.pass(3900ms);
  bench.start_light_on(2s);  // the question would be due after 1.1 s of it
  bench.pass(1950ms);
  CHECK(bench.times_sent("~00124 1\r") == 0);
  bench.projector.light_off();
  CHECK(bench.channel.sent.back().at == bench.clock.now());
  bench.pass(8s);
  bench.channel.sent.clear();
  bench.start_light_on(30s);
  bench.pass(20s);
  CHECK(bench.times_sent("~00124 1\r") >= 3);
}

TEST_CASE("a power off that no projector answers is checked where it can be asked, and sent again") {
  ProjectorTable table = text_table();
  table.power_off.replies.clear();
  Bench bench(table);
  bench.power_on();
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r" && bench.times_sent(message) == 1) return;  // lost
    bench.behave(message);
  };
  bench.projector.power_off();
  bench.pass(4s);
  CHECK(bench.is_on);
  bench.pass(10s);
  CHECK_FALSE(bench.is_on);
  bench.channel.sent.clear();
  bench.pass(60s);
  CHECK(bench.channel.sent.empty());  // the projector has said that it is off
  CHECK(bench.events.empty());
}

TEST_CASE("a projector that stays on though it was turned off is reported, even if power off has no reply") {
  ProjectorTable table = text_table();
  table.power_off.replies.clear();
  Bench bench(table);
  bench.power_on();
  bench.channel.projector = [&](const std::string& message) {
    if (message != "~0000 0\r") bench.behave(message);
  };
  bench.projector.power_off();
  bench.pass(60s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].what ==
        "the lamp may be on: the projector at /dev/ttyUSB7 has not confirmed that it is off");
}

TEST_CASE("power on right after power off waits until the lamp has cooled down") {
  Bench bench;
  bench.power_on();
  bench.projector.power_off();
  bench.pass(1s);
  CHECK(bench.channel.messages() == Messages{"~0002 1\r", "~0000 0\r"});
  CHECK_FALSE(bench.is_on);
  const TimePoint off = bench.clock.now() - 1s;
  bench.channel.sent.clear();
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  REQUIRE(bench.channel.sent.size() == 5);
  CHECK(bench.channel.sent[1].message == "~0000 1\r");
  CHECK(bench.channel.sent[1].at - off >= 60s);
  CHECK(bench.channel.sent[1].at - off < 61s);  // power off was confirmed a few replies after it was asked
}

TEST_CASE("power on right after power off waits for the cool-down too where a projector cannot be asked") {
  ProjectorTable table = text_table();
  table.power.reset();
  Bench bench(table);
  bench.power_on();
  bench.projector.power_off();
  bench.pass(50ms);
  const TimePoint off_at = bench.clock.now();
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.is_on);
  const auto on = std::ranges::find(bench.channel.sent, "~0000 1\r", &ScriptedChannel::Sent::message);
  REQUIRE(on != bench.channel.sent.end());
  CHECK(on->at - off_at >= 60s);
  CHECK(on->at - off_at < 61s);  // a gap and a reply
}

TEST_CASE("a power off that waits for a question to be answered is sent when light off drops the question") {
  ProjectorTable table = text_table();
  table.light_on.reset();
  table.light_off.reset();
  Bench bench(table);
  bench.power_on();
  bench.fall_silent();
  bench.projector.power_off();
  bench.pass(8s);  // three tries of a second; 5 s later power off is sent again
  REQUIRE(bench.is_on);
  bench.projector.ask_status([](const ProjectorStatus&) {});
  bench.pass(500ms);
  bench.channel.projector = [&](const std::string& message) { bench.behave(message); };
  bench.projector.light_off();
  bench.pass(2s);
  CHECK_FALSE(bench.is_on);
}

TEST_CASE("a projector that still cools down from before the program ran is turned on again and again") {
  Bench bench;
  bench.deaf_until = bench.clock.now() + 50s;
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  CHECK(bench.is_on);
}

TEST_CASE("a projector that never comes on is given up in less than the time a print waits for it") {
  Bench bench;
  bench.deaf_until = TimePoint::max();
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  CHECK(bench.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 says that it is off, long after it was turned on");
  CHECK(bench.now() < 300s);  // the print process's deadline
}

TEST_CASE("power off follows a light off that is never confirmed, and ends the light that way") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r") bench.behave(message);
  };
  bench.projector.power_off();
  bench.pass(10s);
  CHECK_FALSE(bench.is_on);
  REQUIRE(bench.events.size() == 2);
  CHECK(bench.events[1].kind == MachineEvent::Kind::Recovery);
  bench.channel.sent.clear();
  bench.projector.light_off();
  bench.pass(60s);
  CHECK(bench.channel.sent.empty());  // off is dark
}

TEST_CASE("power off comes soon once light off is known to be ignored") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.fall_silent();
  bench.projector.light_off();
  bench.pass(10s);
  REQUIRE(bench.events.size() == 1);
  bench.channel.sent.clear();
  const TimePoint asked = bench.clock.now();
  bench.projector.power_off();
  bench.pass(10s);
  REQUIRE(bench.channel.sent.size() > 2);
  CHECK(bench.channel.sent[0].message == "~0002 1\r");
  CHECK(bench.channel.sent[1].message == "~0000 0\r");
  CHECK(bench.channel.sent[1].at - asked < 1200ms);  // one try of light off
}

TEST_CASE("light off does not cancel a pending power off") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.projector.power_off();
  bench.projector.light_off();
  bench.pass(5s);
  CHECK_FALSE(bench.is_on);
  CHECK_FALSE(bench.light);
}

TEST_CASE("a message that a projector sends by itself is a machine event if it matters") {
  Bench bench;
  bench.power_on();
  bench.channel.send("INFO1\r");
  bench.pass(1s);
  CHECK(bench.events.empty());
  bench.channel.send("INFO4\r");
  bench.pass(1s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(bench.events[0].what == "the projector at /dev/ttyUSB7 says: the lamp failed");
  bench.channel.send("INFO2\r");
  bench.pass(1s);
  CHECK(bench.events.size() == 2);
}

TEST_CASE("a projector that cools down because it was told to causes no machine event") {
  Bench bench;
  bench.power_on();
  bench.projector.power_off();
  bench.pass(1s);
  bench.channel.send("INFO2\r");
  bench.pass(1s);
  CHECK(bench.events.empty());
}

TEST_CASE("a line of the projector's own between a command and its reply is not taken for the reply") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.answer_always("INFO1\rP\r");
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
}

TEST_CASE("a serial line that is lost is a fault, and every command is answered at once") {
  Bench bench;
  bench.power_on();
  bench.pass(1s);
  bench.start_light_on();
  const TimePoint unplugged = bench.clock.now();
  bench.channel.unplug();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(bench.answered_at == unplugged);
  bench.projector.light_off();
  bench.pass(60s);
  REQUIRE(bench.events.size() == 1);
  CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
  CHECK(bench.events[0].what ==
        "the serial port /dev/ttyUSB7 was lost: it was unplugged; the projector's light may be on");
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  CHECK(bench.projector.last_problem() ==
        "the projector at /dev/ttyUSB7 cannot be reached: the serial line is lost");
}

TEST_CASE("a projector's status is its power and its lamp hours, and asking changes nothing") {
  Bench bench;
  std::optional<ProjectorStatus> status;
  const auto ask = [&] {
    status.reset();
    bench.projector.ask_status([&](const ProjectorStatus& s) { status = s; });
    bench.pass(10s);
    REQUIRE(status);
  };
  ask();
  CHECK(status->powered == false);
  CHECK_FALSE(status->lamp_hours);
  bench.is_on = true;
  ask();
  CHECK(status->reply == ProjectorReply::Ok);
  CHECK(status->powered == true);
  CHECK(status->lamp_hours == 1234);
  CHECK(bench.channel.messages() == Messages{"~00124 1\r", "~00124 1\r", "~00108 1\r"});
  bench.fall_silent();
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
  ProjectorTable table = text_table();
  table.light_on.reset();
  table.light_off.reset();
  Bench bench(table);
  bench.power_on();
  bench.start_light_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Ok);
  bench.projector.light_off();
  bench.pass(4s);
  CHECK(bench.channel.sent.empty());
  CHECK(bench.events.empty());
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
struct SlowStarter : Bench {
  explicit SlowStarter(Duration warm_after, const std::string& until_then,
                       ProjectorTable table = text_table())
      : Bench(std::move(table)) {
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
  SlowStarter bench(15s, "");
  bench.answers_power_on = false;
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::NoAnswer);
  bench.projector.light_off();
  bench.projector.power_off();
  bench.pass(60s);
  CHECK_FALSE(bench.light);
  CHECK_FALSE(bench.is_on);
}

TEST_CASE("light off between power on and its reply is repeated until the projector comes up and takes it") {
  SlowStarter bench(20s, "F\r");
  bench.reply = 300ms;
  bench.start_power_on();
  while (!bench.is_on)
    REQUIRE(bench.clock.run_next());
  bench.pass(100ms);
  bench.projector.light_off();
  bench.pass(35s);
  CHECK_FALSE(bench.light);
  CHECK(bench.events.empty());
}

TEST_CASE(
    "a print cancelled in a warm-up ends with lamp and light off, whatever is refused and said until then") {
  Bench bench;
  std::optional<TimePoint> on_at;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 1\r") on_at = bench.clock.now(), bench.light = true;
    const bool cold = on_at && bench.clock.now() - *on_at < 20s;
    if (cold && message == "~00124 1\r") return bench.channel.send("OK0\r");
    if (cold && message != "~0000 1\r") return bench.channel.send("F\r");
    bench.behave(message);
  };
  bench.start_power_on();
  while (!on_at)
    REQUIRE(bench.clock.run_next());
  bench.pass(5s);
  bench.projector.light_off();
  bench.projector.power_off();
  bench.pass(60s);
  CHECK_FALSE(bench.light);
  CHECK_FALSE(bench.is_on);
  CHECK(bench.events.empty());
}

TEST_CASE("power on that is refused by a projector that is off does not count as light") {
  Bench bench;
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~00124 1\r") return bench.channel.send("OK0\r");
    bench.channel.send("F\r");
  };
  bench.start_power_on();
  bench.wait_for_answer();
  CHECK(bench.answer == ProjectorReply::Refused);
  bench.projector.light_off();
  bench.projector.power_off();
  bench.pass(120s);
  CHECK(bench.projector.light_off_unconfirmed().empty());
  CHECK(bench.events.empty());
  bench.channel.sent.clear();
  bench.pass(600s);
  CHECK(bench.channel.sent.empty());
}

TEST_CASE("a warm-up that was interrupted is waited for to its end") {
  for (const bool switches_light : {true, false}) {
    for (const bool asks : {true, false}) {
      ProjectorTable table = text_table();
      if (!switches_light) {
        table.light_on.reset();
        table.light_off.reset();
      }
      if (!asks) table.power.reset();
      Bench bench(table);
      bench.start_power_on();
      while (!bench.is_on)
        REQUIRE(bench.clock.run_next());
      const TimePoint on_at = bench.clock.now();
      bench.pass(2s);
      bench.projector.light_off();
      bench.pass(3s);
      bench.start_power_on();
      bench.wait_for_answer();
      CHECK(bench.answer == ProjectorReply::Ok);
      CHECK(bench.answered_at - on_at >= 30s);
      CHECK(bench.answered_at - on_at < 32s);
    }
  }
}

TEST_CASE("power off is repeated until the projector confirms it or says that it is off") {
  for (const std::string& answer : {std::string("F\r"), std::string()}) {
    Bench bench;
    bench.power_on();
    bool takes = false;
    bench.channel.projector = [&](const std::string& message) {
      if (message != "~0000 0\r" || takes) return bench.behave(message);
      if (!answer.empty()) bench.channel.send(answer);
    };
    bench.projector.power_off();
    bench.pass(25s);
    CHECK(bench.is_on);
    CHECK(bench.events.empty());
    bench.pass(20s);
    REQUIRE(bench.events.size() == 1);
    CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
    CHECK(bench.events[0].what.starts_with("the lamp may be on: the projector at /dev/ttyUSB7 "));
    CHECK(bench.events[0].what.find("\"power off\"") != std::string::npos);
    takes = true;
    bench.pass(65s);
    CHECK_FALSE(bench.is_on);
    CHECK(bench.events.size() == 1);
    bench.channel.sent.clear();
    bench.pass(600s);
    CHECK(bench.channel.sent.empty());
  }
}

TEST_CASE("a print that begins while power off is not yet confirmed does not lose its power later") {
  Bench bench;
  bench.power_on();
  bench.channel.projector = [&](const std::string& message) {
    if (message == "~0000 0\r") return bench.channel.send("F\r");
    bench.behave(message);
  };
  bench.projector.power_off();
  bench.pass(12s);
  bench.channel.projector = [&](const std::string& message) { bench.behave(message); };
  bench.power_on();
  bench.pass(120s);
  CHECK(bench.is_on);
}

TEST_CASE("a projector that falls silent or turns itself off in a print is a fault, reported once") {
  for (const bool switches_light : {true, false}) {
    for (const bool silent : {true, false}) {
      ProjectorTable table = text_table();
      if (!switches_light) {
        table.light_on.reset();
        table.light_off.reset();
      }
      Bench bench(table);
      bench.power_on();
      bench.pass(60s);
      CHECK(bench.events.empty());
      bench.is_on = false;
      if (silent) bench.fall_silent();
      // As in a print without light commands: light off comes in between, and nothing is asked.
      for (int layer = 0; layer < 20; ++layer) {
        if (!switches_light) bench.projector.light_off();
        bench.pass(1s);
      }
      REQUIRE(bench.events.size() == 1);
      CHECK(bench.events[0].kind == MachineEvent::Kind::Fault);
      CHECK(bench.events[0].what ==
            (silent ? "the projector at /dev/ttyUSB7 did not answer \"power\" in 3 tries of 1000 ms: is it "
                      "connected, and set to 9600 baud?"
                    : "the projector at /dev/ttyUSB7 says that it is off, although it was not turned off"));
      bench.pass(60s);
      CHECK(bench.events.size() == 1);
    }
  }
}

TEST_CASE("a projector that a crashed process has left on is turned off, unless a print has begun") {
  for (const bool prints : {false, true}) {
    Bench bench;
    bench.is_on = bench.light = true;
    bench.projector.power_off_if_on();
    bench.projector.light_off();
    if (prints) bench.start_power_on();
    bench.pass(30s);
    CHECK(bench.is_on == prints);
    CHECK_FALSE(bench.light);
    if (prints) CHECK(bench.answer == ProjectorReply::Ok);
  }
  Bench off;
  off.projector.power_off_if_on();
  off.pass(30s);
  CHECK(off.channel.messages() == Messages{"~00124 1\r"});
}

TEST_CASE("a projector that was left on and is silent at first is turned off when it answers") {
  Bench bench;
  bench.is_on = true;
  bench.fall_silent();
  bench.projector.power_off_if_on();
  bench.pass(20s);
  bench.channel.projector = [&](const std::string& message) { bench.behave(message); };
  bench.pass(60s);
  CHECK_FALSE(bench.is_on);
  bench.channel.sent.clear();
  bench.pass(5min);
  CHECK(bench.channel.sent.empty());
}

TEST_CASE(
    "a projector that may be warming up is not believed when it refuses light off and says that it is off") {
  for (const bool may_warm_up : {true, false}) {
    CAPTURE(may_warm_up);
    Bench bench;
    bench.channel.projector = [&](const std::string& message) {
      // The projector calls itself on, and obeys light off, once it is warm; then it has a picture of its
      // own.
      const bool warm = bench.clock.now() >= TimePoint{} + 10s;
      if (warm && !bench.is_on) bench.is_on = bench.light = true;
      if (message == "~0002 1\r" && !warm) return bench.channel.send("F\r");
      bench.behave(message);
    };
    std::optional<ProjectorReply> dark;
    if (may_warm_up) bench.projector.may_warm_up();
    bench.projector.confirm_dark([&](ProjectorReply reply) { dark = reply; });
    bench.pass(9s);
    CHECK(dark.has_value() == !may_warm_up);
    bench.pass(6s);
    REQUIRE(dark == ProjectorReply::Ok);
    CHECK(bench.light == false);
  }
}

TEST_CASE("a projector that warms up is not dark because it says that it is off") {
  ProjectorTable table = text_table();
  table.warm_up = 5s;
  Bench bench(table);
  std::optional<TimePoint> warm_at;
  const auto is_warm = [&] { return warm_at && bench.clock.now() >= *warm_at; };
  bench.channel.projector = [&](const std::string& message) {
    // The first answers come as late as may be, so that light off is under way when power on is due.
    if (message == "~00124 1\r")
      return bench.channel.send(is_warm() ? "OK1\r" : "OK0\r", warm_at ? 20ms : 1990ms);
    if (message == "~0000 1\r") warm_at = bench.clock.now() + 4900ms;
    if (message == "~0002 1\r") {
      if (!is_warm()) return;
      bench.light = true;
    }
    bench.channel.send("P\r");
  };
  bench.projector.may_warm_up();
  bench.projector.light_off();
  bench.start_power_on();
  while (!bench.answer) {
    bench.clock.run_next();
    const bool has_a_picture = is_warm() && !bench.light;
    if (has_a_picture) CHECK_FALSE(bench.projector.light_off_unconfirmed().empty());
  }
  CHECK(bench.answer == ProjectorReply::Ok);
}

TEST_CASE("a projector that comes on while it may be warming up is turned off") {
  Bench bench;
  const auto warm = bench.clock.call_after(12s, [&] { bench.is_on = true; });
  bench.projector.may_warm_up();
  bench.projector.power_off_if_on();
  bench.pass(11s);
  CHECK(bench.times_sent("~0000 0\r") == 0);
  bench.pass(10s);
  CHECK(bench.times_sent("~0000 0\r") == 1);
  CHECK_FALSE(bench.is_on);
  bench.channel.sent.clear();
  bench.pass(60s);
  CHECK(bench.channel.sent.empty());
}
