#include "daemon/ctl/setup/setup_questions.hpp"

#include "daemon/ctl/terminal/dialog.hpp"
#include "tests/catch.hpp"

using namespace contourd::ctl;

namespace {

// Returns the facts of a Raspberry Pi 4 with a connected projector.
SetupFacts pi_4() {
  SetupFacts facts;
  FoundChip chip{"gpiochip0", "pinctrl-bcm2711", {}};
  for (int i = 0; i < 58; ++i)
    chip.lines.push_back({"GPIO" + std::to_string(i), std::nullopt});
  chip.lines[2].user = "i2c";
  chip.lines[5].user = "contourd step";
  facts.devices.chips = {chip};
  facts.devices.outputs = {{"HDMI-A-1", false, {}}, {"HDMI-A-2", true, {"1280x800", "1024x768"}}};
  facts.devices.ports = {{"/dev/serial/by-id/usb-FTDI", "ttyUSB0"}};
  facts.tables = {{"acer", false}, {"optoma", true}};
  return facts;
}

std::string complaint(std::string_view key, const std::string& typed, const Answers& answers,
                      const SetupFacts& facts) {
  return find_question(key)->take(typed, answers, facts).complaint;
}

Suggestion suggestion(std::string_view key, const Answers& answers, const SetupFacts& facts) {
  return find_question(key)->suggest(answers, facts);
}

}  // namespace

TEST_CASE("Every question accepts its own suggestion, with and without devices") {
  for (const SetupFacts& facts : {SetupFacts{}, pi_4()}) {
    for (const char* table : {"none", "optoma", "acer"}) {
      for (const char* end : {"bottom", "top"}) {
        Answers answers{{"hardware", "real"}, {"switch_end", end}};
        if (facts.tables.contains(table)) answers["projector_table"] = table;
        for (const Question& question : questions()) {
          const std::string key(question.key);
          if (!question.is_asked(answers, facts) || answers.contains(key)) continue;
          const Suggestion usual = question.suggest(answers, facts);
          const TakenAnswer taken = question.take(usual.answer, answers, facts);
          INFO(key << " = " << usual.answer);
          CHECK(taken.complaint.empty());
          CHECK_FALSE(usual.why.empty());
          answers[key] = taken.answer;
        }
      }
    }
  }
}

TEST_CASE("For a simulated printer, only its name is asked") {
  const SetupFacts facts;
  CHECK(suggestion("hardware", {}, facts).answer == "simulated");
  CHECK(suggestion("hardware", {}, pi_4()).answer == "real");
  int asked = 0;
  for (const Question& question : questions())
    asked += question.is_asked({{"hardware", "simulated"}}, facts) ? 1 : 0;
  CHECK(asked == 2);
}

TEST_CASE("A line must exist on the chip, be free and be used only once") {
  const SetupFacts facts = pi_4();
  Answers answers{{"hardware", "real"}, {"gpio_chip", "pinctrl-bcm2711"}, {"step_line", "17"}};
  CHECK(complaint("direction_line", "27", answers, facts).empty());
  CHECK(complaint("direction_line", "GPIO27", answers, facts).empty());
  CHECK(complaint("direction_line", "GPIO17", answers, facts) ==
        "Line GPIO17 is already used for step_line.");
  CHECK(complaint("direction_line", "58", answers, facts) ==
        "pinctrl-bcm2711 has no line \"58\"; it has lines 0 to 57.");
  CHECK(complaint("direction_line", "2", answers, facts) == "Line 2 is in use: \"i2c\" holds it.");
  CHECK(complaint("direction_line", "5", answers, facts).empty());  // contourd's own
  for (const char* word : {"-1", "1.5", "", "none", "017x", "1e99", "99999999999999999999"})
    CHECK_FALSE(complaint("direction_line", word, answers, facts).empty());
  CHECK(complaint("enable_line", "none", answers, facts).empty());
  // A conflict is reported at the later of two questions.
  answers["direction_line"] = "27";
  CHECK(complaint("step_line", "27", answers, facts).empty());
  CHECK_FALSE(complaint("direction_line", "17", answers, facts).empty());
}

TEST_CASE("The light needs a line if the projector's table cannot switch it") {
  const SetupFacts facts = pi_4();
  Answers answers{{"hardware", "real"}, {"projector_table", "optoma"}};
  CHECK(suggestion("light_line", answers, facts).answer == "none");
  CHECK(complaint("light_line", "none", answers, facts).empty());
  for (const char* table : {"acer", "none"}) {
    answers["projector_table"] = table;
    CHECK_FALSE(suggestion("light_line", answers, facts).safe);
    CHECK_FALSE(complaint("light_line", "none", answers, facts).empty());
  }
}

TEST_CASE("Devices that were found are suggested, and others are refused") {
  const SetupFacts facts = pi_4();
  const Answers answers{{"hardware", "real"}, {"connector", "HDMI-A-2"}};
  CHECK(suggestion("gpio_chip", answers, facts).answer == "pinctrl-bcm2711");
  CHECK(suggestion("connector", answers, facts).answer == "HDMI-A-2");
  CHECK(suggestion("display_mode", answers, facts).answer == "1280x800@60");
  CHECK(suggestion("serial_port", answers, facts).answer == "/dev/serial/by-id/usb-FTDI");
  CHECK(complaint("serial_port", "/dev/ttyUSB0", answers, facts).empty());
  CHECK_FALSE(complaint("serial_port", "/dev/ttyUSB1", answers, facts).empty());
  CHECK_FALSE(complaint("serial_port", "ttyUSB0", answers, facts).empty());
  CHECK_FALSE(complaint("display_mode", "1920x1080@60", answers, facts).empty());
  for (const char* mode : {"1920", "1920x", "0x0", "99999x1@60", "1024x768@", "1024x768@0", "1024x768x", ""})
    CHECK_FALSE(complaint("display_mode", mode, answers, facts).empty());
  CHECK_FALSE(complaint("connector", "HDMI-A-3", answers, facts).empty());
}

TEST_CASE("Steps and pixels come from the user's answers, or from measurements") {
  Answers answers{{"screw_lead_mm", "2"},
                  {"steps_per_turn", "200"},
                  {"microsteps", "32"},
                  {"display_mode", "1920x1080@60"},
                  {"build_width_mm", "96"}};
  CHECK(microsteps_per_mm(answers) == 3200);
  CHECK(pixel_pitch_um(answers) == 50);
  answers["microsteps_per_mm"] = "3210.5";
  answers["pixel_pitch_um"] = "49.5";
  CHECK(microsteps_per_mm(answers) == 3210.5);
  CHECK(pixel_pitch_um(answers) == 49.5);
}

TEST_CASE("The suggested top speed never exceeds the step rate of an axis") {
  for (const char* lead : {"1", "2", "4", "8"}) {
    for (const char* microsteps : {"8", "16", "32", "64"}) {
      const Answers answers{{"screw_lead_mm", lead}, {"steps_per_turn", "200"}, {"microsteps", microsteps}};
      const double speed = number_of(suggestion("top_speed_mm_s", answers, {}).answer).value();
      CHECK(speed * microsteps_per_mm(answers) <= 20'000);
      CHECK(speed >= 0.1);
    }
  }
}

TEST_CASE("A word may be shortened as long as it is unambiguous") {
  const auto take = find_question("switch_contact")->take;
  CHECK(take("normally_o", {}, {}).answer == "normally_open");
  CHECK_FALSE(take("normally", {}, {}).complaint.empty());
  CHECK_FALSE(take("", {}, {}).complaint.empty());
}

TEST_CASE("The suggested name is the printer's current name, if it has one") {
  SetupFacts facts;
  CHECK(suggestion("name", {}, facts).answer == "Resin printer");
  facts.name = "Left of the window";
  CHECK(suggestion("name", {}, facts).answer == "Left of the window");
}
