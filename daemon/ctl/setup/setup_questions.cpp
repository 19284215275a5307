#include "daemon/ctl/setup/setup_questions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd::ctl {
namespace {

constexpr const char* kNone = "none";
constexpr double kUsualSpeed_mm_s = 5;
constexpr double kResinsSpeed_mm_s = 3;
constexpr double kStepsForAnyPi = 5'000;  // steps per second; docs/printer-setup.md

TakenAnswer refused(std::string sentence) {
  return {"", std::move(sentence)};
}

// --- conditions of questions

bool has(const Answers& answers, const std::string& key, std::string_view answer) {
  const auto found = answers.find(key);
  return found != answers.end() && found->second == answer;
}

bool given(const Answers& answers, const std::string& key) {
  return answers.contains(key);
}

bool is_real(const Answers& answers, const SetupFacts& /*facts*/) {
  return has(answers, "hardware", "real");
}

bool always(const Answers& /*answers*/, const SetupFacts& /*facts*/) {
  return true;
}

bool with_table(const Answers& answers, const SetupFacts& facts) {
  return is_real(answers, facts) && given(answers, "projector_table") &&
         !has(answers, "projector_table", kNone);
}

// True if the projector's table cannot switch the light, so that a GPIO line must.
bool light_needs_line(const Answers& answers, const SetupFacts& facts) {
  if (!with_table(answers, facts)) return true;
  const auto table = facts.tables.find(answers.at("projector_table"));
  return table != facts.tables.end() && !table->second;
}

// --- kinds of answers

auto suggest(std::string answer, std::string why, bool safe = true) {
  return [suggestion = Suggestion{std::move(answer), std::move(why), safe}](
             const Answers&, const SetupFacts&) { return suggestion; };
}
// Suggests a value that differs from machine to machine, so it is not safe without asking.
auto guess(std::string answer, std::string why) {
  return suggest(std::move(answer), std::move(why), false);
}

// Refuses an answer that is none of these words.
TakenAnswer expected(const std::vector<std::string>& words) {
  return refused(printable(fmt::format("Expected one of: {}.", fmt::join(words, ", "))));
}

// Takes one of the words, or the beginning of exactly one.
TakenAnswer take_word(const std::string& typed, const std::vector<std::string>& words) {
  if (std::ranges::find(words, typed) != words.end()) return {typed, ""};
  const auto fits = [&](const std::string& word) { return word.starts_with(typed); };
  if (std::ranges::count_if(words, fits) != 1) return expected(words);
  return {*std::ranges::find_if(words, fits), ""};
}

auto one_of(std::vector<std::string> words) {
  return [words = std::move(words)](const std::string& typed, const Answers&, const SetupFacts&) {
    return take_word(typed, words);
  };
}

TakenAnswer take_number(const std::string& typed, double least, double most, const char* unit) {
  const std::optional<double> number = number_of(typed);
  if (number && *number >= least && *number <= most) return {fmt::format("{}", *number), ""};
  return refused(fmt::format("Expected a number from {} to {}{}{}, with a decimal point if needed.", least,
                             most, *unit != 0 ? " " : "", unit));
}

auto number(double least, double most, const char* unit) {
  return [=](const std::string& typed, const Answers&, const SetupFacts&) {
    return take_number(typed, least, most, unit);
  };
}

TakenAnswer take_whole(const std::string& typed, int least, int most) {
  const std::optional<double> number = number_of(typed);
  if (number && *number >= least && *number <= most && *number == std::floor(*number))
    return {fmt::format("{}", *number), ""};
  return refused(fmt::format("Expected a whole number from {} to {}.", least, most));
}

// --- GPIO

constexpr const char* kLineKeys[] = {"step_line", "direction_line", "enable_line", "switch_line",
                                     "light_line"};

const FoundChip* chosen_chip(const Answers& answers, const SetupFacts& facts) {
  return given(answers, "gpio_chip") ? find_chip(facts.devices, answers.at("gpio_chip")) : nullptr;
}

Suggestion suggest_chip(const Answers& /*answers*/, const SetupFacts& facts) {
  const FoundChip* const chip = header_chip(facts.devices);
  if (chip == nullptr) return {"gpiochip0", "the header's chip on a Raspberry Pi 3 and 4", true};
  const auto same = std::ranges::count(facts.devices.chips, chip->label, &FoundChip::label);
  // A label stays the same when the kernel numbers the chips differently.
  return {same == 1 && !chip->label.empty() ? chip->label : chip->name, "this chip has the header's lines",
          true};
}

TakenAnswer take_chip(const std::string& typed, const Answers& /*answers*/, const SetupFacts& facts) {
  if (typed.size() > 200) return refused("A chip's name has at most 200 characters.");
  if (facts.devices.chips.empty() || find_chip(facts.devices, typed) != nullptr) return {typed, ""};
  std::vector<std::string> names;
  for (const FoundChip& chip : facts.devices.chips)
    names.push_back(fmt::format("{} ({})", chip.name, chip.label));
  return refused(printable(
      fmt::format("This computer has no chip {}; it has: {}.", in_quotes(typed), fmt::join(names, ", "))));
}

std::optional<std::size_t> number_of_line(const FoundChip& chip, const std::string& word) {
  std::size_t number = 0;
  const char* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end)
    return number < chip.lines.size() ? std::optional(number) : std::nullopt;
  const auto line = std::ranges::find(chip.lines, word, &FoundLine::name);
  if (line == chip.lines.end()) return std::nullopt;
  return static_cast<std::size_t>(line - chip.lines.begin());
}

// True if another program than contourd holds the line. A running contourd does not count.
bool is_taken(const FoundLine& line) {
  return line.user && !line.user->starts_with("contourd");
}

bool same_line(const FoundChip* chip, const std::string& one, const std::string& other) {
  if (one == other) return true;
  return chip != nullptr && number_of_line(*chip, one) &&
         number_of_line(*chip, one) == number_of_line(*chip, other);
}

auto line_for(std::string key, bool may_be_none) {
  return [key = std::move(key), may_be_none](const std::string& typed, const Answers& answers,
                                             const SetupFacts& facts) {
    if (typed == kNone && may_be_none && !(key == "light_line" && light_needs_line(answers, facts)))
      return TakenAnswer{typed, ""};
    if (typed == kNone)
      return refused("This line is needed: a number, such as 17, or a name, such as GPIO17.");
    if (typed.size() > 100 || typed.starts_with('-') ||
        (number_of(typed) && take_whole(typed, 0, 65535).answer != typed))
      return refused("A line is a number from 0 to 65535, such as 17, or a name, such as GPIO17.");
    const FoundChip* const chip = chosen_chip(answers, facts);
    for (const char* other : kLineKeys) {
      if (other == key) break;  // later lines are checked when their questions are answered
      if (given(answers, other) && same_line(chip, typed, answers.at(other)))
        return refused(printable(fmt::format("Line {} is already used for {}.", typed, other)));
    }
    if (chip == nullptr) return TakenAnswer{typed, ""};
    const std::optional<std::size_t> number = number_of_line(*chip, typed);
    if (!number)
      return refused(printable(fmt::format("{} has no line {}; it has lines 0 to {}.", chip->label,
                                           in_quotes(typed), chip->lines.size() - 1)));
    if (is_taken(chip->lines[*number]))
      return refused(printable(
          fmt::format("Line {} is in use: {} holds it.", typed, in_quotes(*chip->lines[*number].user))));
    return TakenAnswer{typed, ""};
  };
}

// --- display

std::optional<DisplayMode> mode_of(const std::string& word) {
  DisplayMode mode;
  int used = 0;
  if (std::sscanf(word.c_str(), "%dx%d%n", &mode.width_px, &mode.height_px, &used) != 2) return std::nullopt;
  const std::string rest = word.substr(static_cast<std::size_t>(used));
  if (!rest.empty() && !rest.starts_with('@')) return std::nullopt;
  const std::optional<double> refresh = rest.empty() ? 60 : number_of(rest.substr(1));
  if (!refresh) return std::nullopt;
  mode.refresh_hz = *refresh;
  constexpr int kMost = 16384;
  const bool fits = mode.width_px >= 1 && mode.width_px <= kMost && mode.height_px >= 1 &&
                    mode.height_px <= kMost && mode.refresh_hz >= 1 && mode.refresh_hz <= 240;
  return fits ? std::optional(mode) : std::nullopt;
}

const FoundOutput* chosen_output(const Answers& answers, const SetupFacts& facts) {
  if (!given(answers, "connector")) return nullptr;
  const auto output = std::ranges::find(facts.devices.outputs, answers.at("connector"), &FoundOutput::name);
  return output != facts.devices.outputs.end() ? &*output : nullptr;
}

Suggestion suggest_connector(const Answers& /*answers*/, const SetupFacts& facts) {
  if (const FoundOutput* const output = connected_output(facts.devices))
    return {output->name, "a display is connected to it", true};
  const bool found = !facts.devices.outputs.empty();
  return {found ? facts.devices.outputs.front().name : "HDMI-A-1",
          found ? "the first output; no display is connected" : "the first HDMI port of a Raspberry Pi",
          true};
}

TakenAnswer take_connector(const std::string& typed, const Answers& /*answers*/, const SetupFacts& facts) {
  if (typed.size() > 100) return refused("An output's name has at most 100 characters.");
  std::vector<std::string> names;
  for (const FoundOutput& output : facts.devices.outputs)
    names.push_back(output.name);
  if (names.empty() || std::ranges::find(names, typed) != names.end()) return {typed, ""};
  return expected(names);
}

Suggestion suggest_mode(const Answers& answers, const SetupFacts& facts) {
  const FoundOutput* const output = chosen_output(answers, facts);
  if (output != nullptr && !output->modes.empty() && mode_of(output->modes.front()))
    return {output->modes.front() + "@60", "the size that the projector prefers", true};
  return {"1920x1080@60", "a usual mode; the projector's modes are unknown", false};
}

TakenAnswer take_mode(const std::string& typed, const Answers& answers, const SetupFacts& facts) {
  const std::optional<DisplayMode> mode = mode_of(typed);
  if (!mode) return refused("Expected WIDTHxHEIGHT@HZ, such as 1920x1080@60.");
  const std::string size = fmt::format("{}x{}", mode->width_px, mode->height_px);
  const FoundOutput* const output = chosen_output(answers, facts);
  if (output != nullptr && !output->modes.empty() &&
      std::ranges::find(output->modes, size) == output->modes.end())
    return refused(printable(fmt::format("The projector does not support {}; it supports: {}.", size,
                                         fmt::join(output->modes, ", "))));
  return {fmt::format("{}@{}", size, mode->refresh_hz), ""};
}

// Limits of the pixel pitch.
constexpr double kSmallestPixel_um = 1, kLargestPixel_um = 1000;

TakenAnswer take_width(const std::string& typed, const Answers& answers, const SetupFacts& /*facts*/) {
  const double per_um = display_mode(answers).width_px / 1000.0;
  return take_number(typed, kSmallestPixel_um * per_um, kLargestPixel_um * per_um, "mm");
}

// --- axis

// Returns the speed in mm/s, rounded down to 0.1 mm/s.
double speed_of(double steps_per_second, double per_mm) {
  return std::floor(10 * steps_per_second / per_mm) / 10;
}

Suggestion suggest_top_speed(const Answers& answers, const SetupFacts& /*facts*/) {
  const double per_mm = microsteps_per_mm(answers);
  const double easy = speed_of(kStepsForAnyPi, per_mm);
  if (easy >= kUsualSpeed_mm_s)
    return {fmt::format("{}", kUsualSpeed_mm_s), "slow enough for any screw and motor"};
  if (easy >= kResinsSpeed_mm_s)
    return {fmt::format("{}", easy), "every Raspberry Pi sustains 5,000 steps per second"};
  const double speed = std::max(0.1, std::min(kResinsSpeed_mm_s, speed_of(kMaxStepsPerSecond, per_mm)));
  return {fmt::format("{}", speed),
          "resins need about 3; contourd --check-hardware shows the rate that this computer sustains"};
}

TakenAnswer take_top_speed(const std::string& typed, const Answers& answers, const SetupFacts& /*facts*/) {
  const double per_mm = microsteps_per_mm(answers);
  const double most = std::clamp(speed_of(kMaxStepsPerSecond, per_mm), 0.1, 50.0);
  return take_number(typed, 0.1, most, "mm/s");
}

TakenAnswer take_microsteps(const std::string& typed, const Answers& answers, const SetupFacts& /*facts*/) {
  const TakenAnswer taken = take_whole(typed, 1, 256);
  if (!taken.complaint.empty()) return taken;
  const double steps = number_in(answers, "steps_per_turn") * number_of(taken.answer).value_or(0);
  const double per_mm = steps / number_in(answers, "screw_lead_mm");
  // The slowest top speed, 0.1 mm/s, must be possible.
  if (per_mm >= 1 && per_mm <= kMaxStepsPerSecond) return taken;
  return refused(
      fmt::format("This would be {:g} microsteps per mm; contourd accepts 1 to {:g}: check screw_lead_mm, "
                  "steps_per_turn and microsteps.",
                  per_mm, kMaxStepsPerSecond));
}

Suggestion suggest_switch_height(const Answers& answers, const SetupFacts& /*facts*/) {
  return {answers.at("travel_mm"), "a switch at the top is at the end of the travel", true};
}

TakenAnswer take_switch_height(const std::string& typed, const Answers& answers,
                               const SetupFacts& /*facts*/) {
  return take_number(typed, number_in(answers, "travel_mm"), 600, "mm");
}

// --- projector

std::vector<std::string> table_names(const SetupFacts& facts) {
  std::vector<std::string> names;
  for (const auto& [name, switches] : facts.tables)
    names.push_back(name);
  names.emplace_back(kNone);
  return names;
}

TakenAnswer take_table(const std::string& typed, const Answers& /*answers*/, const SetupFacts& facts) {
  return take_word(typed, table_names(facts));
}

Suggestion suggest_port(const Answers& /*answers*/, const SetupFacts& facts) {
  if (facts.devices.ports.size() == 1)
    return {facts.devices.ports.front().path, "the only serial port", true};
  if (!facts.devices.ports.empty()) return {facts.devices.ports.front().path, "the first serial port", false};
  return {"/dev/ttyUSB0", "the usual name of a USB adapter; none is plugged in", false};
}

TakenAnswer take_port(const std::string& typed, const Answers& /*answers*/, const SetupFacts& facts) {
  if (!typed.starts_with("/dev/") || typed.size() > 200 || printable(typed) != typed)
    return refused("Expected a device below /dev, such as /dev/ttyUSB0 or a link in /dev/serial/by-id.");
  std::vector<std::string> paths;
  for (const FoundPort& port : facts.devices.ports) {
    if (typed == port.path || typed == "/dev/" + port.tty) return {typed, ""};
    paths.push_back(port.path);
  }
  if (paths.empty()) return {typed, ""};
  return refused(
      printable(fmt::format("There is no port {}; there are: {}.", typed, fmt::join(paths, ", "))));
}

Suggestion suggest_light_line(const Answers& answers, const SetupFacts& facts) {
  if (light_needs_line(answers, facts))
    return {"24", "only a line can switch the light; this line of the header is free", false};
  return {kNone, "the projector switches its light by its serial line", true};
}

// --- all

Suggestion suggest_hardware(const Answers& /*answers*/, const SetupFacts& facts) {
  if (facts.devices.chips.empty()) return {"simulated", "there is no GPIO chip for a motor", true};
  if (facts.devices.outputs.empty()) return {"simulated", "there is no display output for masks", true};
  return {"real", "there are GPIO lines and a display output", true};
}

Suggestion suggest_name(const Answers& /*answers*/, const SetupFacts& facts) {
  return facts.name.empty() ? Suggestion{"Resin printer", "any name will do"}
                            : Suggestion{facts.name, "its current name"};
}

TakenAnswer take_name(const std::string& typed, const Answers& /*answers*/, const SetupFacts& /*facts*/) {
  if (typed.empty() || typed.size() > 100 || printable(typed) != typed)
    return refused("A name has 1 to 100 printable characters.");
  return {typed, ""};
}

auto unless_given(std::string key) {
  return [key = std::move(key)](const Answers& answers, const SetupFacts& facts) {
    return is_real(answers, facts) && !given(answers, key);
  };
}
// True if a check has measured the value or the user has given it. The question is never asked by itself.
auto only_given(std::string key) {
  return [key = std::move(key)](const Answers& answers, const SetupFacts& facts) {
    return is_real(answers, facts) && given(answers, key);
  };
}
auto where(std::string key, std::string answer) {
  return [key = std::move(key), answer = std::move(answer)](const Answers& answers, const SetupFacts& facts) {
    return is_real(answers, facts) && has(answers, key, answer);
  };
}
auto where_wired(std::string key) {
  return [key = std::move(key)](const Answers& answers, const SetupFacts& facts) {
    return is_real(answers, facts) && given(answers, key) && !has(answers, key, kNone);
  };
}

std::vector<Question> axis_questions() {
  return {
      {"screw_lead_mm", "How far does the plate rise in one turn of the screw, mm (pitch times starts)?",
       unless_given("microsteps_per_mm"), guess("8", "a T8 screw with four starts; other screws have 2 or 4"),
       number(0.1, 100, "mm")},
      {"steps_per_turn", "How many full steps does the motor make per turn?",
       unless_given("microsteps_per_mm"), suggest("200", "1.8 degrees per step, like most motors"),
       [](const std::string& typed, const Answers&, const SetupFacts&) {
         return take_whole(typed, 20, 10'000);
       }},
      {"microsteps", "How many microsteps per full step does the driver make (see its jumpers)?",
       unless_given("microsteps_per_mm"), suggest("16", "all three jumpers of an A4988"), take_microsteps},
      {"microsteps_per_mm", "How many microsteps move the plate by 1 mm?", only_given("microsteps_per_mm"),
       suggest("800", "as measured"), number(1, kMaxStepsPerSecond, "microsteps")},
      {"travel_mm", "How high above the film can the plate go, mm?", is_real,
       guess("160", "a usual travel; if unsure, enter less"), number(1, 500, "mm")},
      {"top_speed_mm_s", "How fast may the plate move, mm/s?", is_real, suggest_top_speed, take_top_speed},
  };
}

std::vector<Question> line_questions() {
  return {
      {"gpio_chip", "Which GPIO chip are motor and switch wired to?", is_real, suggest_chip, take_chip},
      {"step_line", "Which line is wired to the driver's STEP?", is_real,
       suggest("17", "pin 11 of the header, as in docs/printer-setup.md"), line_for("step_line", false)},
      {"direction_line", "Which line is wired to its DIR?", is_real,
       suggest("27", "pin 13 of the header, as in docs/printer-setup.md"), line_for("direction_line", false)},
      {"direction_active_low", "Does the plate rise while DIR is low (yes or no)?", is_real,
       suggest("no", "a check inverts it if necessary"), one_of({"yes", "no"})},
      {"enable_line", "Which line is wired to its ENABLE, or none?", is_real,
       suggest("22", "pin 15 of the header, as in docs/printer-setup.md"), line_for("enable_line", true)},
      {"enable_active_low", "Is the motor on while ENABLE is low (yes or no)?", where_wired("enable_line"),
       suggest("yes", "true for A4988, DRV8825 and TMC drivers"), one_of({"yes", "no"})},
      {"switch_line", "Which line is wired to the limit switch?", is_real,
       suggest("23", "pin 16 of the header, as in docs/printer-setup.md"), line_for("switch_line", false)},
      {"switch_contact", "Is its contact normally_closed or normally_open?", is_real,
       suggest("normally_closed", "a broken wire is then detected"),
       one_of({"normally_closed", "normally_open"})},
      {"switch_wired_to", "Does the contact connect the line to ground or to supply (3.3 V)?", is_real,
       suggest("ground", "the computer's own resistor then pulls the line up"), one_of({"ground", "supply"})},
      {"switch_end", "Is the switch at the bottom or at the top of the travel?", is_real,
       suggest("bottom", "it closes near the height at which the plate touches the film"),
       one_of({"bottom", "top"})},
      {"switch_height_mm", "How high above the film is the plate at the switch, mm?",
       where("switch_end", "top"), suggest_switch_height, take_switch_height},
  };
}

std::vector<Question> light_questions() {
  return {
      {"projector_table", "Which table of serial commands does the projector understand, or none?", is_real,
       guess(kNone, "the light is then switched by a GPIO line"), take_table},
      {"serial_port", "Which serial port is the projector connected to?", with_table, suggest_port,
       take_port},
      {"light_line", "Which line switches the light (an LED driver's enable, a shutter), or none?", is_real,
       suggest_light_line, line_for("light_line", true)},
      {"light_active_low", "Is the light on while that line is low (yes or no)?", where_wired("light_line"),
       suggest("no", "with a pull-down, a line that is not driven then keeps the light off"),
       one_of({"yes", "no"})},
      {"connector", "Which output is the projector connected to?", is_real, suggest_connector,
       take_connector},
      {"display_mode", "Which size and refresh rate does its picture have?", is_real, suggest_mode,
       take_mode},
      {"build_width_mm", "How wide is the lit picture on the film, mm?", unless_given("pixel_pitch_um"),
       [](const Answers& answers, const SetupFacts&) {
         return Suggestion{fmt::format("{}", display_mode(answers).width_px * 0.05),
                           "pixels of 50 um; measure it", false};
       },
       take_width},
      {"pixel_pitch_um", "How large is a pixel on the film, um?", only_given("pixel_pitch_um"),
       suggest("50", "as measured"), number(kSmallestPixel_um, kLargestPixel_um, "um")},
      {"mirror", "Must the picture be mirrored: none, x, y, both (both: rotated by 180 degrees)?", is_real,
       suggest(kNone, "the pattern border shows whether it must be"), one_of({kNone, "x", "y", "both"})},
      {"irradiance_mw_cm2", "How strong is a white pixel's light on the film, mW/cm²?", is_real,
       suggest("5", "usual for a converted projector; measure it, or find exposures by tests"),
       number(0.01, 1000, "mW/cm²")},
      {"wait_for_plate_cleared",
       "Does the next job wait for confirmation that the plate is clear (yes or no)?", is_real,
       suggest("yes", "a part on the plate would be driven into the film"), one_of({"yes", "no"})},
  };
}

std::vector<Question> all_questions() {
  std::vector<Question> all{{"hardware", "Is this a real printer, or a simulated one that needs no devices?",
                             always, suggest_hardware, one_of({"real", "simulated"})},
                            {"name", "What is the printer's name?", always, suggest_name, take_name}};
  for (auto* part : {axis_questions, line_questions, light_questions})
    std::ranges::move(part(), std::back_inserter(all));
  return all;
}

}  // namespace

double number_in(const Answers& answers, const std::string& key) {
  const auto answer = answers.find(key);
  expects(answer != answers.end(), "the question has been answered");
  const std::optional<double> number = number_of(answer->second);
  expects(number.has_value(), "the answer is a number");
  return *number;
}

std::span<const Question> questions() {
  static const std::vector<Question> all = all_questions();
  return all;
}

const Question* find_question(std::string_view key) {
  const auto found = std::ranges::find(questions(), key, &Question::key);
  return found != questions().end() ? &*found : nullptr;
}

std::string question_keys() {
  std::vector<std::string_view> keys;
  for (const Question& question : questions())
    keys.push_back(question.key);
  return fmt::format("{}", fmt::join(keys, ", "));
}

double microsteps_per_mm(const Answers& answers) {
  expects(given(answers, "microsteps_per_mm") || given(answers, "screw_lead_mm"),
          "the screw has been answered");
  if (given(answers, "microsteps_per_mm")) return number_in(answers, "microsteps_per_mm");
  return number_in(answers, "steps_per_turn") * number_in(answers, "microsteps") /
         number_in(answers, "screw_lead_mm");
}

double pixel_pitch_um(const Answers& answers) {
  if (given(answers, "pixel_pitch_um")) return number_in(answers, "pixel_pitch_um");
  return number_in(answers, "build_width_mm") * 1000 / display_mode(answers).width_px;
}

DisplayMode display_mode(const Answers& answers) {
  const auto answer = answers.find("display_mode");
  expects(answer != answers.end(), "the mode has been answered");
  const std::optional<DisplayMode> mode = mode_of(answer->second);
  expects(mode.has_value(), "the mode is valid");
  return *mode;
}

}  // namespace contourd::ctl
