#include "daemon/config/projector_table.hpp"

#include <filesystem>

#include "hw/serial/serial_projector.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/hw/serial/scripted_channel.hpp"

namespace contourd {
namespace {

using nlohmann::json;

ProjectorTable load_table(const json& table) {
  const ConfigFolder folder;
  return load_projector_table(folder.write_json("table.json", table));
}

Complaints table_complaints(const json& table) {
  return complaints_of([&] { (void)load_table(table); });
}

json optoma() {
  return shipped("projectors/optoma.json");
}

std::string bytes(std::initializer_list<int> values) {
  std::string all;
  for (const int value : values)
    all += static_cast<char>(value);
  return all;
}

// A projector with a shipped table on a serial line with scripted answers; the tests check every message.
struct Conversation {
  explicit Conversation(const std::string& brand, std::optional<std::int32_t> brightness = {})
      : projector(channel, clock, load_table(shipped("projectors/" + brand + ".json")), brightness) {
    channel.projector = [this](const std::string& message) {
      for (const auto& [sent, answer] : answers) {
        if (sent == message) channel.send(answer);
      }
    };
    projector.on_event([this](const MachineEvent& one) { events.push_back(one.what); });
  }

  void pass(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over)
      clock.run_next();
  }
  // Runs until the answer to power on; after that, the projector is asked regularly whether it is still on.
  std::optional<ProjectorReply> power_on() {
    std::optional<ProjectorReply> reply;
    channel.sent.clear();
    projector.power_on([&](ProjectorReply r) { reply = r; });
    while (!reply)
      REQUIRE(clock.run_next());
    return reply;
  }
  std::optional<ProjectorReply> light_on() {
    std::optional<ProjectorReply> reply;
    channel.sent.clear();
    projector.light_on(std::chrono::seconds{1},
                       {.sent = [](TimePoint) {}, .done = [&](ProjectorReply r) { reply = r; }});
    while (!reply)
      REQUIRE(clock.run_next());
    pass(std::chrono::seconds{1});
    return reply;
  }
  void light_off() {
    channel.sent.clear();
    projector.light_off();
    pass(std::chrono::seconds{2});
  }
  void power_off() {
    channel.sent.clear();
    projector.power_off();
    pass(std::chrono::seconds{2});
  }
  ProjectorStatus status() {
    std::optional<ProjectorStatus> status;
    channel.sent.clear();
    projector.ask_status([&](const ProjectorStatus& s) { status = s; });
    while (!status)
      REQUIRE(clock.run_next());
    return *status;
  }

  VirtualClock clock;
  testing::ScriptedChannel channel{clock};
  std::vector<std::pair<std::string, std::string>> answers;
  std::vector<std::string> events;
  SerialProjector projector;
};

using Messages = std::vector<std::string>;

TEST_CASE("Acer's table sends Acer's commands, and the state of the lamp is the answer") {
  Conversation talk("acer");
  talk.answers = {{"* 0 IR 001\r", "*001\r"}, {"* 0 IR 002\r", "*001\r"}, {"* 0 Lamp ?\r", "*000\rLamp 1\r"}};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"* 0 Lamp ?\r"});
  CHECK(talk.status().powered == true);
  talk.answers[2].second = "Lamp 0\r";
  CHECK(talk.status().powered == false);
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{"* 0 IR 002\r"});
  talk.answers[2].second = "*000\r";  // the acknowledgement of a question is not an answer to it
  CHECK(talk.status().reply == ProjectorReply::NoAnswer);
  talk.power_on();
  CHECK(talk.channel.messages()[3] == "* 0 IR 001\r");
  CHECK_FALSE(load_table(shipped("projectors/acer.json")).switches_light());
}

TEST_CASE("Optoma's table covers power, AV mute, queries and unasked messages of the projector") {
  Conversation talk("optoma");
  talk.answers = {{"~0000 1\r", "P\r"}, {"~0000 0\r", "P\r"},    {"~0002 0\r", "P\r"},
                  {"~0002 1\r", "P\r"}, {"~00124 1\r", "OK1\r"}, {"~00108 1\r", "OK0815\r"}};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"~00124 1\r", "~0002 1\r"});
  CHECK(talk.light_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"~0002 0\r"});
  talk.light_off();
  CHECK(talk.channel.messages() == Messages{"~0002 1\r"});
  CHECK(talk.status().powered == true);
  CHECK(talk.status().lamp_hours == 815);
  talk.channel.send("INFO7\r");
  talk.pass(std::chrono::seconds{1});
  CHECK(talk.events == Messages{"the projector at /dev/ttyUSB7 says: it is too hot"});
  talk.answers[2].second = "F\r";
  CHECK(talk.light_on() == ProjectorReply::Refused);
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{"~0002 1\r", "~0000 0\r"});
}

TEST_CASE("Vivitek's table waits for no reply where none is documented, and for a minute after off") {
  Conversation talk("vivitek-d535");
  talk.answers = {{"~qP\r", "ON\r"}, {"~qL\r", "77\r"}};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.status().lamp_hours == 77);
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{"~PF\r", "~qP\r"});  // asks whether the projector is off
  const TimePoint off = talk.channel.sent[0].at;
  bool is_on = false;
  talk.channel.projector = [&](const std::string& message) {
    if (message == "~PN\r") is_on = true;
    if (message == "~qP\r") talk.channel.send(is_on ? "ON\r" : "OFF\r");
  };
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"~qP\r", "~PN\r", "~qP\r"});
  CHECK(talk.channel.sent[1].at - off >= std::chrono::seconds{60});
}

TEST_CASE("BenQ's table ignores echoes and prompts and distinguishes blank from light") {
  Conversation talk("benq");
  const auto answer = [](const std::string& command, const std::string& reply) {
    return std::pair{"\r*" + command + "#\r", ">*" + command + "#\r\n*" + reply + "#\r\n>"};
  };
  talk.answers = {answer("pow=?", "POW=ON"),        answer("blank=on", "BLANK=ON"),
                  answer("blank=off", "BLANK=OFF"), answer("ltim=?", "LTIM=4711"),
                  answer("pow=off", "POW=OFF"),     answer("blank=?", "BLANK=ON")};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"\r*pow=?#\r", "\r*blank=on#\r"});
  CHECK(talk.light_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{"\r*blank=off#\r"});
  CHECK(talk.status().lamp_hours == 4711);
  talk.light_off();
  talk.answers[2].second = ">*blank=off#\r\n*Block item#\r\n";
  CHECK(talk.light_on() == ProjectorReply::Refused);
  CHECK(talk.channel.messages()[0] == "\r*blank=off#\r");
  // An echo alone is not a reply; the answer to the question is that the projector is dark.
  talk.answers[2].second = "*blank=off#\r";
  CHECK(talk.light_on() == ProjectorReply::NoAnswer);
  CHECK(talk.channel.messages() == Messages{"\r*blank=off#\r", "\r*blank=?#\r", "\r*blank=on#\r"});
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{"\r*blank=on#\r", "\r*pow=off#\r"});
}

TEST_CASE("ViewSonic's table sends the manual's bytes and verifies the checksums of replies") {
  const std::string on = bytes({6, 0x14, 0, 4, 0, 0x34, 0x11, 0, 0, 0x5D});
  const std::string off = bytes({6, 0x14, 0, 4, 0, 0x34, 0x11, 1, 0, 0x5E});
  const std::string power = bytes({7, 0x14, 0, 5, 0, 0x34, 0, 0, 0x11, 0, 0x5E});
  const std::string lamp = bytes({7, 0x14, 0, 5, 0, 0x34, 0, 0, 0x15, 1, 0x63});
  const std::string yes = bytes({3, 0x14, 0, 0, 0, 0x14});
  Conversation talk("viewsonic-pjd7820hd");
  // 0x1234 hours; the sum after the first byte is 14 + 6 + 34 + 12 = 60.
  talk.answers = {{power, bytes({5, 0x14, 0, 3, 0, 0, 0, 1, 0x18})},
                  {lamp, bytes({5, 0x14, 0, 6, 0, 0, 0, 0x34, 0x12, 0, 0, 0x60})},
                  {off, yes},
                  {on, yes}};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{power});
  CHECK(talk.status().lamp_hours == 0x1234);
  CHECK(talk.channel.messages() == Messages{power, lamp});
  talk.answers[1].second.back() = 0x61;
  CHECK(talk.status().reply == ProjectorReply::NoAnswer);
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{off});
  talk.answers[0].second = bytes({5, 0x14, 0, 3, 0, 0, 0, 0, 0x17});
  CHECK(talk.power_on() == ProjectorReply::Refused);  // the projector reports off until the end
  CHECK(talk.channel.messages()[1] == on);
}

TEST_CASE("Anhua's table mixes bytes and text, and sets the brightness") {
  const std::string on = bytes({0x2A, 0xFA, 0x0D}), off = bytes({0x2A, 0xFB, 0x0D});
  const std::string led_on = bytes({0x2A, 0x4B, 0x0D}), led_off = bytes({0x2A, 0x47, 0x0D});
  Conversation talk("anhua-df10", 440);
  talk.answers = {{on, bytes({0x2A, 0xFA, 0, 0x0D})},
                  {off, bytes({0x2A, 0xFB, 0, 0x0D})},
                  {led_on, bytes({0x2A, 0x4B, 0, 0x0D})},
                  {led_off, bytes({0x2A, 0x47, 0, 0x0D})},
                  {"CM+LEDS=440\r\n", "OK\r\n"}};
  CHECK(talk.power_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{on, led_off, led_off, "CM+LEDS=440\r\n"});
  CHECK(talk.light_on() == ProjectorReply::Ok);
  CHECK(talk.channel.messages() == Messages{led_on});
  talk.light_off();
  talk.answers[2].second[2] = 1;
  CHECK(talk.light_on() == ProjectorReply::Refused);
  CHECK(talk.channel.messages()[0] == led_on);
  talk.power_off();
  CHECK(talk.channel.messages() == Messages{led_off, off});
}

TEST_CASE("every shipped projector table can be read") {
  int tables = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(CONTOURD_CONFIG_DIR) / "projectors")) {
    INFO(file.path());
    CHECK(complaints_of([&] { (void)load_projector_table(file.path()); }).empty());
    ++tables;
  }
  CHECK(tables == 6);
}

TEST_CASE("a projector table's keys are read with their units and defaults") {
  json table = optoma();
  table.erase("retries");
  table.erase("gap_ms");
  table["commands"]["power_on"]["timeout_ms"] = 5000;
  const ProjectorTable read = load_table(table);
  CHECK(read.name == "Optoma");
  CHECK(read.baud == 9600);
  CHECK_FALSE(read.echo);
  CHECK(read.retries == 2);
  CHECK(read.gap == std::chrono::milliseconds{50});
  CHECK(read.warm_up == std::chrono::seconds{30});
  CHECK(read.cool_down == std::chrono::seconds{60});
  CHECK(read.power_on.timeout == std::chrono::seconds{5});
  CHECK(read.power_off.timeout == std::chrono::seconds{1});
  CHECK(read.power_off.name == "power off");
  CHECK(read.switches_light());
  CHECK(read.unasked.size() == 7);
}

TEST_CASE("an invalid reply pattern is reported with the reason when the table is read") {
  json table = optoma();
  table["commands"]["power"]["on"] = "OK(1";
  table["commands"]["lamp_hours"]["value"] = "OK\\d+";
  table["commands"]["power_off"]["accepted"] = "(P)";
  table["unasked"][2]["line"] = "INFO[2";
  const Complaints complaints = table_complaints(table);
  REQUIRE(complaints.size() == 4);
  CHECK(complaints[0] ==
        "/commands/lamp_hours/value: it has 0 groups; write one group around the value's digits, and all "
        "others as (?:...)");
  // The rest is libstdc++'s message.
  CHECK(complaints[1].starts_with("/commands/power/on: \"OK(1\" is not a regular expression: "));
  CHECK(complaints[2] == "/commands/power_off/accepted: no value is expected here: write groups as (?:...)");
  CHECK(complaints[3].starts_with("/unasked/2/line: \"INFO[2\" is not a regular expression: "));
}

TEST_CASE("invalid bytes and wrong checksums are reported when the table is read") {
  json table = shipped("projectors/viewsonic-pjd7820hd.json");
  table["commands"]["power_on"]["hex"] = "06 14 00 04 00 34 11 00 00 5E";
  table["commands"]["power_off"]["hex"] = "06 14 0";
  table["commands"]["power"]["on"] = "05 14 xx";
  table["commands"]["lamp_hours"]["value"] = "05 14 sum 00";
  CHECK(
      table_complaints(table) ==
      Complaints{
          "/commands/lamp_hours/value: \"sum\" must come last",
          "/commands/power/on: \"xx\" is not a byte; write two hex digits, \"..\" for any byte, \"(..)\" for "
          "the "
          "value's, or \"sum\"",
          "/commands/power_off/hex: \"0\" is not a byte; write two hex digits, or \"sum\" for the checksum",
          "/commands/power_on/hex: its last byte is 5E, but the checksum is 5D"});
  table = shipped("projectors/anhua-df10.json");
  table["commands"]["light_on"]["hex"] = "2A 4B sum";
  CHECK(table_complaints(table) ==
        Complaints{
            "/commands/light_on/hex: \"sum\" stands for a checksum, but the table's checksum is \"none\""});
}

TEST_CASE("light on and light off need each other and a reply that confirms them") {
  json table = optoma();
  table["commands"].erase("light_off");
  CHECK(table_complaints(table) == Complaints{"/commands/light_on: it also needs light_off"});
  table = optoma();
  table["commands"]["light_off"].erase("accepted");
  CHECK(table_complaints(table).size() == 1);
}

TEST_CASE("a reply that noise can match does not confirm that the light is off") {
  for (const std::string any : {".*", ".+", ".", "....", "[^F]*", "\\w+", "\\w{3,}", "(?:P|.{5})", "\\S+"}) {
    json table = optoma();
    table["commands"]["light_off"]["accepted"] = any;
    CHECK(table_complaints(table) ==
          Complaints{"/commands/light_off/accepted: " + json(any).dump() +
                     " also matches noise: the light would be taken for off when it may be on"});
  }
  json table = shipped("projectors/anhua-df10.json");
  table["commands"]["light_off"]["accepted"] = ".. .. ..";
  CHECK(table_complaints(table) ==
        Complaints{
            "/commands/light_off/accepted: \".. .. ..\" also matches noise: the light would be taken for "
            "off when it may be on"});
}

TEST_CASE("a reply that can be a refusal does not confirm that the light is off") {
  const std::string rest =
      " also matches the reply \"refused\": the light would be taken for off when it may be on";
  json table = optoma();
  table["commands"]["light_off"]["accepted"] = "F";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off/accepted: \"F\"" + rest});
  table["commands"]["light_off"]["accepted"] = "[PF]";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off/accepted: \"[PF]\"" + rest});
  table["commands"]["light_off"]["accepted"] = table["commands"]["light_off"]["refused"] = "(?:NG|ERR)\\d";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off/accepted: \"(?:NG|ERR)\\\\d\"" + rest});
  table = shipped("projectors/anhua-df10.json");
  table["commands"]["light_off"]["accepted"] = "2a  .. ff 0d";
  table["commands"]["light_off"]["refused"] = "2A .. FF 0D";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off/accepted: \"2a  .. ff 0d\"" + rest});
}

TEST_CASE("a reply of a projector that is on must not match the reply for off") {
  const std::string place = "/commands/power/off: ",
                    off = ": the light would be taken for off when it may be on";
  json table = optoma();
  for (const std::string any : {".*", "O?\\w+"}) {
    table["commands"]["power"]["off"] = any;
    CHECK(table_complaints(table) == Complaints{place + json(any).dump() + " also matches noise" + off});
  }
  table["commands"]["power"]["off"] = "F";
  CHECK(table_complaints(table) == Complaints{place + "\"F\" also matches the reply \"refused\"" + off});
  for (const std::string both : {"O[Kk]1", "OK1", "O[Kk][01]?.?"}) {
    table["commands"]["power"] = {{"text", "~00124 1"}, {"on", "O[Kk]1"}, {"off", both}};
    if (both.ends_with('?')) table["commands"]["power"]["on"] = "OK1";
    CHECK(table_complaints(table) ==
          Complaints{place + json(both).dump() + " also matches the reply \"on\"" + off});
  }
  table["commands"]["power"] = {{"text", "~00124 1"}, {"on", ".*"}, {"off", "OK0"}};
  CHECK(table_complaints(table) == Complaints{place + "\"OK0\" also matches the reply \"on\"" + off});
  table = shipped("projectors/benq.json");
  table["commands"]["power"]["off"] = ">?\\*POW=.*#";
  CHECK(table_complaints(table) ==
        Complaints{place + "\">?\\\\*POW=.*#\" also matches the reply \"on\"" + off});
  table = shipped("projectors/viewsonic-pjd7820hd.json");
  for (const std::string both : {"05 14 00 03 00 00 00 01 sum", "05 14 00 03 00 00 00 .. sum"}) {
    table["commands"]["power"]["off"] = both;
    CHECK(table_complaints(table) ==
          Complaints{place + json(both).dump() + " also matches the reply \"on\"" + off});
  }
}

TEST_CASE("a reply that can be a refusal does not confirm that the light is on") {
  json table = optoma();
  table["commands"]["light_on"]["accepted"] = "[PF]";
  CHECK(table_complaints(table) == Complaints{"/commands/light_on/accepted: \"[PF]\" also matches the reply "
                                              "\"refused\": the light would be taken for "
                                              "on when it may be off"});
}

TEST_CASE("power off must not send the same bytes as power on") {
  json table = optoma();
  table["commands"]["power_off"]["text"] = "~0000 1";
  CHECK(table_complaints(table) == Complaints{"/commands/power_off: it sends the same bytes as power_on"});
}

TEST_CASE("light off must not send the same bytes as light on") {
  json table = optoma();
  table["commands"]["light_off"]["text"] = "~0002 0";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off: it sends the same bytes as light_on"});
  table = shipped("projectors/anhua-df10.json");
  table["commands"]["light_on"]["hex"] = "2A 47 0d";
  CHECK(table_complaints(table) == Complaints{"/commands/light_off: it sends the same bytes as light_on"});
}

TEST_CASE("a brightness command needs a place for its number and a range") {
  json table = shipped("projectors/anhua-df10.json");
  table["commands"]["brightness"]["text"] = "CM+LEDS=";
  table["commands"]["brightness"]["minimum"] = 2000;
  CHECK(table_complaints(table) ==
        Complaints{"/commands/brightness: it must contain {}, the place of the number",
                   "/commands/brightness/minimum: 2000 is more than maximum, 1023"});
  table["commands"]["brightness"] = {{"hex", "2A 4C {} 0D"}, {"minimum", 0}, {"maximum", 300}};
  table["commands"]["light_on"]["hex"] = "2A {} 0D";
  CHECK(table_complaints(table) ==
        Complaints{"/commands/brightness/maximum: 300 does not fit in one byte",
                   "/commands/light_on: only the brightness command may contain {}, the place of a number"});
}

TEST_CASE("a command has either a text or bytes, and violations of rules and schema are reported together") {
  json table = optoma();
  table["baud"] = 110;
  table["commands"]["power_on"]["hex"] = "2A";
  table["commands"]["power_off"]["accepted"] = "P(";
  table["comands"] = 1;
  CHECK(table_complaints(table).size() == 4);
}

}  // namespace
}  // namespace contourd
