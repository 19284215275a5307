#include "daemon/ctl/setup/setup_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/contract/expects.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kHomingSpeed_mm_s = 3;
constexpr int kWarmUp_s = 30;
constexpr int kAcceleration_mm_s2 = 25;

// Returns the number as a person writes it: 5 for 5.0, rounded to six decimals.
Json plain(double number) {
  constexpr double kDigits = 1e6;
  const double rounded = std::round(number * kDigits) / kDigits;
  const auto whole = static_cast<std::int64_t>(rounded);
  if (static_cast<double>(whole) == rounded) return whole;
  return rounded;
}

bool is_yes(const Answers& answers, const char* key) {
  const auto answer = answers.find(key);
  return answer != answers.end() && answer->second == "yes";
}

// Returns the line's configuration; a numeric answer becomes a number, a name stays a text.
Json line_of(const Answers& answers, const char* key, bool active_low) {
  const std::string& word = answers.at(key);
  const std::optional<double> number = number_of(word);
  return {{"chip", answers.at("gpio_chip")},
          {"line", number ? plain(*number) : Json(word)},
          {"active_low", active_low}};
}

void set_line(Json& section, const char* name, const Answers& answers, const char* key, const char* low_key) {
  if (answers.at(key) == "none")
    section.erase(name);
  else
    section[name] = line_of(answers, key, is_yes(answers, low_key));
}

void set_switch(Json& axis, const Answers& answers) {
  const bool to_ground = answers.at("switch_wired_to") == "ground";
  Json input = line_of(answers, "switch_line", to_ground);
  // The resistor pulls in the opposite direction to the contact.
  input["bias"] = to_ground ? "pull_up" : "pull_down";
  input["contact"] = answers.at("switch_contact");
  axis["limit_switch"] = input;
}

void set_axis(Json& axis, const Answers& answers) {
  const double top_speed = number_in(answers, "top_speed_mm_s");
  axis["travel_mm"] = plain(number_in(answers, "travel_mm"));
  axis["microsteps_per_mm"] = plain(microsteps_per_mm(answers));
  axis["homing_speed_mm_s"] = plain(std::min(kHomingSpeed_mm_s, top_speed));
  axis["travel_speed_mm_s"] = plain(top_speed);
  axis["top_speed_mm_s"] = plain(top_speed);
  if (!axis.contains("acceleration_mm_s2")) axis["acceleration_mm_s2"] = kAcceleration_mm_s2;
  const bool was_top = axis.value("homes_upwards", false);
  axis.erase("homes_upwards");
  if (answers.at("switch_end") == "top") {
    axis["homes_upwards"] = true;
    axis["switch_height_mm"] = plain(number_in(answers, "switch_height_mm"));
  } else if (was_top) {
    axis.erase("switch_height_mm");  // otherwise keep the height from levelling
  }
  axis["step"] = line_of(answers, "step_line", false);
  axis["direction"] = line_of(answers, "direction_line", is_yes(answers, "direction_active_low"));
  set_line(axis, "enable", answers, "enable_line", "enable_active_low");
  set_switch(axis, answers);
}

void set_display(Json& display, const Answers& answers) {
  const DisplayMode mode = display_mode(answers);
  const std::string& mirror = answers.at("mirror");
  display["connector"] = answers.at("connector");
  display["width_px"] = mode.width_px;
  display["height_px"] = mode.height_px;
  display["refresh_hz"] = plain(mode.refresh_hz);
  display["pixel_pitch_um"] = plain(pixel_pitch_um(answers));
  display["mirror_x"] = mirror == "x" || mirror == "both";
  display["mirror_y"] = mirror == "y" || mirror == "both";
}

void set_projector(Json& projector, const Answers& answers) {
  projector["irradiance_mw_cm2"] = plain(number_in(answers, "irradiance_mw_cm2"));
  if (!projector.contains("warm_up_s")) projector["warm_up_s"] = kWarmUp_s;
  if (const std::string& table = answers.at("projector_table"); table != "none") {
    if (projector.value("table", "") != table)
      projector.erase("brightness");  // the limits are another table's
    projector["port"] = answers.at("serial_port");
    projector["table"] = table;
  } else {
    for (const char* key : {"port", "table", "brightness"})
      projector.erase(key);
  }
  set_line(projector, "light", answers, "light_line", "light_active_low");
}

}  // namespace

Answers asked_answers(const Answers& answers, const SetupFacts& facts) {
  Answers asked;
  for (const Question& question : questions()) {
    const auto answer = answers.find(std::string(question.key));
    if (answer != answers.end() && question.is_asked(answers, facts)) asked.insert(*answer);
  }
  return asked;
}

Json profile_of(const Answers& answers, Json base) {
  expects(answers.contains("name") && answers.contains("hardware"),
          "every question that is asked was answered");
  base["name"] = answers.at("name");
  base["hardware"] = answers.at("hardware");
  if (answers.at("hardware") != "real") return base;
  base["wait_for_plate_cleared"] = is_yes(answers, "wait_for_plate_cleared");
  set_axis(base["z_axis"], answers);
  set_display(base["display"], answers);
  set_projector(base["projector"], answers);
  return base;
}

std::vector<ExplainedAnswer> explained(const Answers& answers, const SetupFacts& facts) {
  std::vector<ExplainedAnswer> all;
  for (const Question& question : questions()) {
    if (!question.is_asked(answers, facts)) continue;
    const std::string key(question.key);
    expects(answers.contains(key), "every question that is asked was answered");
    const std::string& answer = answers.at(key);
    const Suggestion suggestion = question.suggest(answers, facts);
    const bool by_default = question.take(suggestion.answer, answers, facts).answer == answer;
    all.push_back({key, answer, by_default ? suggestion.why : "as answered"});
  }
  return all;
}

std::string notes_of(const Answers& answers, const SetupFacts& facts, const std::string& config) {
  std::string notes = fmt::format(
      "Choices of contourctl setup for {}, with their reasons. man contourd.json explains each key.\n\n",
      printable(config));
  for (const std::string& line : describe(facts.devices))
    notes += line + "\n";
  for (const ExplainedAnswer& each : explained(answers, facts))
    notes += fmt::format("\n{}\n  {} = {}: {}\n", find_question(each.key)->text, each.key,
                         printable(each.answer), printable(each.why));
  return notes;
}

}  // namespace contourd::ctl
