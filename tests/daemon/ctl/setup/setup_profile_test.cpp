#include "daemon/ctl/setup/setup_profile.hpp"

#include "tests/catch.hpp"

using namespace contourd::ctl;
using Json = nlohmann::ordered_json;

namespace {

Answers real_answers() {
  return {{"hardware", "real"},
          {"name", "Mine"},
          {"screw_lead_mm", "4"},
          {"steps_per_turn", "200"},
          {"microsteps", "16"},
          {"travel_mm", "150"},
          {"top_speed_mm_s", "5"},
          {"gpio_chip", "pinctrl-rp1"},
          {"step_line", "17"},
          {"direction_line", "GPIO27"},
          {"direction_active_low", "yes"},
          {"enable_line", "none"},
          {"switch_line", "23"},
          {"switch_contact", "normally_open"},
          {"switch_wired_to", "supply"},
          {"switch_end", "bottom"},
          {"projector_table", "none"},
          {"light_line", "24"},
          {"light_active_low", "no"},
          {"connector", "HDMI-A-1"},
          {"display_mode", "1920x1080@59.94"},
          {"build_width_mm", "57.6"},
          {"mirror", "both"},
          {"irradiance_mw_cm2", "7.5"},
          {"wait_for_plate_cleared", "no"}};
}

Json base() {
  return Json::parse(R"({"name": "x", "resin": "grey", "hardware": "simulated",
    "z_axis": {"travel_mm": 1, "acceleration_mm_s2": 40, "switch_height_mm": 0.2, "enable": {"line": 22},
               "emergency_stop": {"line": 5}},
    "display": {"gamma": 2.2}, "projector": {"warm_up_s": 9, "port": "/dev/ttyUSB0", "table": "benq", "brightness": 3}})");
}

}  // namespace

TEST_CASE("Answers set their keys, and all other keys keep their values") {
  const Json profile = profile_of(real_answers(), base());
  CHECK(profile["name"] == "Mine");
  CHECK(profile["resin"] == "grey");
  CHECK(profile["wait_for_plate_cleared"] == false);
  const Json& axis = profile["z_axis"];
  CHECK(axis["microsteps_per_mm"] == 800);
  CHECK(axis["microsteps_per_mm"].is_number_integer());
  CHECK(axis["acceleration_mm_s2"] == 40);
  CHECK(axis["switch_height_mm"] == 0.2);
  CHECK(axis["emergency_stop"]["line"] == 5);
  CHECK_FALSE(axis.contains("enable"));
  CHECK(axis["direction"] == Json{{"chip", "pinctrl-rp1"}, {"line", "GPIO27"}, {"active_low", true}});
  CHECK(profile["display"]["pixel_pitch_um"] == 30);
  CHECK(profile["display"]["refresh_hz"] == 59.94);
  CHECK(profile["display"]["gamma"] == 2.2);
  CHECK(profile["display"]["mirror_x"] == true);
  CHECK(profile["display"]["mirror_y"] == true);
  CHECK(profile["projector"] ==
        Json{{"warm_up_s", 9},
             {"irradiance_mw_cm2", 7.5},
             {"light", {{"chip", "pinctrl-rp1"}, {"line", 24}, {"active_low", false}}}});
}

TEST_CASE("The resistor of a switch pulls in the opposite direction to its contact") {
  Answers answers = real_answers();
  for (const char* contact : {"normally_open", "normally_closed"}) {
    answers["switch_contact"] = contact;
    answers["switch_wired_to"] = "ground";
    Json input = profile_of(answers, base())["z_axis"]["limit_switch"];
    CHECK(input["active_low"] == true);
    CHECK(input["bias"] == "pull_up");
    CHECK(input["contact"] == contact);
    answers["switch_wired_to"] = "supply";
    input = profile_of(answers, base())["z_axis"]["limit_switch"];
    CHECK(input["active_low"] == false);
    CHECK(input["bias"] == "pull_down");
  }
}

TEST_CASE("A switch that was moved from the top to the bottom loses its height") {
  Answers answers = real_answers();
  answers["switch_end"] = "top";
  answers["switch_height_mm"] = "151";
  const Json top = profile_of(answers, base());
  CHECK(top["z_axis"]["homes_upwards"] == true);
  CHECK(top["z_axis"]["switch_height_mm"] == 151);
  answers["switch_end"] = "bottom";
  const Json bottom = profile_of(answers, top);
  CHECK_FALSE(bottom["z_axis"].contains("homes_upwards"));
  CHECK_FALSE(bottom["z_axis"].contains("switch_height_mm"));
}

TEST_CASE("A simulated printer keeps a real printer's keys in its file") {
  const Json profile = profile_of({{"hardware", "simulated"}, {"name", "Dry"}}, base());
  Json wanted = base();
  wanted["name"] = "Dry";
  CHECK(profile == wanted);
}

TEST_CASE("The notes have every answer with its reason, and no control characters") {
  const SetupFacts facts;
  Answers answers = real_answers();
  answers["connector"] = "HDMI\x1b[2J";
  const std::string notes = notes_of(answers, facts, "/etc/contourd/contourd.json");
  CHECK(notes.find("microsteps = 16: all three jumpers of an A4988\n") != std::string::npos);
  CHECK(notes.find("travel_mm = 150: as answered\n") != std::string::npos);
  CHECK(notes.find('\x1b') == std::string::npos);
}

TEST_CASE("Answers that later answers have made pointless are left out") {
  Answers answers = real_answers();
  answers["serial_port"] = "/dev/ttyUSB0";
  answers["switch_height_mm"] = "151";
  const Answers asked = asked_answers(answers, {});
  CHECK_FALSE(asked.contains("serial_port"));
  CHECK_FALSE(asked.contains("switch_height_mm"));
  CHECK(asked.size() == real_answers().size());
}
