#include "daemon/ctl/setup/setup_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/setup/setup_daemon.hpp"
#include "daemon/ctl/setup/setup_questions.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"

namespace contourd::ctl {
namespace {

using Json = SetupDaemon::Json;
using namespace std::chrono_literals;

constexpr const char* kConfiguration = "configuration";
constexpr const char* kPassed = "passed";
constexpr auto kAskInterval = 100ms;
constexpr double kLight_s = 5;       // to look at a picture
constexpr double kShortLight_s = 2;  // whose end is looked at
constexpr double kMost_mm = 500;

enum class Outcome { Passed, Skipped };

class Checks {
 public:
  explicit Checks(const SetupChecks& with)
      : with_(with),
        dialog_(with.dialog),
        answers_(with.record.answers),
        outcomes_(with.record.checks),
        daemon_(with.client, with.dialog) {}

  void run() {
    bool running = true;
    for (const Check& check : kAll) {
      if (!applies(check) || outcomes_[check.name] == kPassed) continue;
      running = running && take_configuration();
      const bool passed = running && make(check) == Outcome::Passed;
      outcomes_[check.name] = passed ? kPassed : "skipped";
      with_.keep();
    }
    tell_end();
  }

 private:
  struct Check {
    const char* name;
    const char* what;
    const char* later;
    Outcome (Checks::*make)();
  };
  static const Check kAll[9];

  [[nodiscard]] bool is(const char* key, const char* answer) const {
    const auto found = answers_.find(key);
    return found != answers_.end() && found->second == answer;
  }
  [[nodiscard]] bool applies(const Check& check) const {
    return std::string_view(check.name) != "projector" || !is("projector_table", "none");
  }

  // What keeps the daemon from doing it is said, and asked for again.
  Outcome make(const Check& check) {
    fmt::print("\n");
    dialog_.say(fmt::format("Check: {}.", check.what));
    while (true) {
      try {
        return (this->*check.make)();
      } catch (const DaemonError& error) {
        dialog_.say(fmt::format("{}.", error.what()));
      }
      if (dialog_.ask_for_word("Enter: once more; skip:", {"again", "skip"}) == "skip")
        return Outcome::Skipped;
    }
  }

  void tell_end() {
    fmt::print("\n");
    std::string skipped;
    for (const Check& check : kAll) {
      if (!applies(check) || outcomes_[check.name] == kPassed) continue;
      if (skipped.empty()) dialog_.say("Not checked:");
      skipped = check.later;
      dialog_.say(fmt::format("  {}: {}", check.what, check.later), 4);
    }
    if (skipped.empty()) dialog_.say("All checks are passed.");
    if (outcomes_[kConfiguration] == "written")
      dialog_.say("contourd takes the configuration by: sudo systemctl reload-or-restart contourd");
    dialog_.say("Next: sudo contourctl level, for the plate; then docs/printing.md.");
  }

  // False: without.
  bool take_configuration() {
    if (outcomes_[kConfiguration] != "written") return true;
    if (!daemon_.start_anew(with_.config, answers_.at("name"))) return false;
    outcomes_[kConfiguration] = "taken";
    with_.keep();
    return true;
  }
  // The answer, and the configuration with it, which contourd takes. False: not so, and it is as it was, or
  // contourd is not to take it now.
  bool set_and_take(const char* key, const std::string& answer) {
    const Answers before = answers_;
    answers_[key] = answer;
    if (with_.write()) return take_configuration();
    answers_ = before;
    return false;
  }
  bool skips(const std::string& prompt) { return dialog_.ask_for_word(prompt, {"go", "skip"}) == "skip"; }

  // --- the checks

  Outcome check_switch() {
    if (skips("Leave the switch alone. Enter: its line is looked at; skip:")) return Outcome::Skipped;
    const Json rest = daemon_.limit_switch();
    const bool reached = rest["active"].get<bool>();
    dialog_.say(fmt::format("It is on {}. Now press it and let it go, by hand. Enter: skip.",
                            rest.value("line", "")));
    const auto edges = rest.value("edges", std::uint64_t{0});
    while (daemon_.limit_switch().value("edges", std::uint64_t{0}) == edges)
      if (dialog_.typed_within(kAskInterval)) return Outcome::Skipped;
    dialog_.say("Its line changes: it is wired.");
    if (!reached) return Outcome::Passed;
    const char* const other = is("switch_contact", "normally_closed") ? "normally_open" : "normally_closed";
    dialog_.say(
        fmt::format("But it counted as reached while it was left alone, so its contact is {}: switch_contact "
                    "becomes that.",
                    other));
    return set_and_take("switch_contact", other) ? Outcome::Passed : Outcome::Skipped;
  }

  // Two millimetres at most, until the switch closes: nobody knows yet which way it goes, and how far.
  Outcome check_direction() {
    dialog_.say(
        "Which way does the plate go? Vat out, plate in the middle of its travel, nothing in its way, a hand "
        "at the power. It goes 2 mm up, slowly, by the steps that were answered, and stops at the switch.");
    while (true) {
      if (skips("Enter: it moves; skip:")) return Outcome::Skipped;
      daemon_.control("move", {{"by_mm", 2}, {"unhomed", true}, {"plate_is_clear", true}},
                      "The plate is not moved");
      const std::string way =
          dialog_.ask_for_word("It went: up, down, or not at all (no)?", {"again", "up", "down", "no"});
      if (way == "up") return Outcome::Passed;
      if (way == "no") {
        dialog_.say("Look at the driver's supply, its current, ENABLE and STEP, then again.");
      } else if (way == "down") {
        dialog_.say("So DIR is turned round.");
        if (!set_and_take("direction_active_low", is("direction_active_low", "yes") ? "no" : "yes"))
          return Outcome::Skipped;
      }
    }
  }

  Outcome check_homing() {
    dialog_.say(
        "The switch is as it was, the plug in. Nothing is on the plate or in its way, the vat is out. A "
        "hand at the power: the plate goes to its switch, and stops there.");
    constexpr int kTimes = 2;
    if (skips("Enter: twice; skip:")) return Outcome::Skipped;
    for (int i = 0; i < kTimes; ++i) {
      daemon_.control("home", {{"plate_is_clear", true}}, "The plate is not homed");
      if (i + 1 < kTimes) daemon_.control("move", {{"to_mm", middle()}}, "The plate is not moved");
    }
    const bool near = tell_shift();
    const bool stopped =
        dialog_.ask_for_word("Did it stop at the switch both times (yes or no)?", {"yes", "no"}) == "yes";
    return near && stopped ? Outcome::Passed : Outcome::Skipped;
  }
  // By the steps between both homings. False: by so much that they cannot be right.
  bool tell_shift() {
    const std::optional<double> shift = daemon_.homing_shift_um();
    if (!shift) return true;
    constexpr double kLayer_um = 50;  // a usual one
    dialog_.say(fmt::format("The switch was {}.", describe_homing_shift(*shift)));
    if (std::abs(*shift) <= kLayer_um) return true;
    dialog_.say(
        "That is more than a layer. Coupling or switch may be loose, or the motor loses steps: it wants more "
        "current, or a lower homing_speed_mm_s or top_speed_mm_s.");
    return false;
  }
  [[nodiscard]] double middle() const { return std::min(20.0, number_in(answers_, "travel_mm") / 2); }

  // A short way first: nobody knows yet how far it goes.
  Outcome check_steps() {
    if (!daemon_.height_mm()) {
      dialog_.say("The plate's position is unknown: it has to be homed before.");
      return Outcome::Skipped;
    }
    const double travel = number_in(answers_, "travel_mm"), from = travel / 4, way = travel / 4;
    if (skips(fmt::format("How far is a millimetre? Vat out. Enter: the plate goes to {:g} mm; skip:", from)))
      return Outcome::Skipped;
    daemon_.control("move", {{"to_mm", from}, {"plate_is_clear", true}}, "The plate is not moved");
    (void)dialog_.ask(
        fmt::format("Measure the plate's height with a caliper. Enter: {:g} mm further up.", way));
    daemon_.control("move", {{"to_mm", from + way}}, "The plate is not moved");
    const auto measured =
        dialog_.ask_for_number("By how much is it higher now, mm (Enter: skip)?", 0.1, kMost_mm);
    if (!measured) return Outcome::Skipped;
    const double before = microsteps_per_mm(answers_), now = before * way / *measured;
    // As well as a caliper tells it.
    constexpr double kSame = 0.002;
    if (std::abs(now / before - 1) <= kSame) {
      dialog_.say(fmt::format("That is right: {:g} microsteps are a millimetre.", before));
      return Outcome::Passed;
    }
    dialog_.say(
        fmt::format("{:g} mm were meant: {:g} microsteps would be a millimetre, not {:g}. If it is off by 2, "
                    "4 or so, microsteps or screw_lead_mm is wrong; else the caliper may be.",
                    way, now, before));
    if (dialog_.ask_for_word("Is microsteps_per_mm to become that (no or yes)?", {"no", "yes"}) == "no")
      return Outcome::Skipped;
    return set_and_take("microsteps_per_mm", fmt::format("{:.6g}", now)) ? Outcome::Passed : Outcome::Skipped;
  }

  Outcome check_projector() {
    if (skips("Enter: the projector is asked how it is; skip:")) return Outcome::Skipped;
    daemon_.control("projector", Json::object(), "The projector does not answer as its table says");
    const Json status = daemon_.ask("status");
    const Json& projector = status["manual"]["projector"];
    if (!projector.is_object() || !projector["powered"].is_boolean()) {
      dialog_.say("Its table has no command to ask that.");
      return Outcome::Skipped;
    }
    return Outcome::Passed;
  }

  // Lit with that pattern, after a question. False: not.
  bool light(const char* pattern, double seconds) {
    const std::string answer = dialog_.ask_for_word(
        fmt::format("UV light for {:g} s, with {}. No resin in the vat, eyes protected (no or yes)?", seconds,
                    pattern),
        {"no", "yes"});
    if (answer != "yes") return false;
    daemon_.light(pattern, seconds);
    return true;
  }

  Outcome check_picture() {
    dialog_.say(
        "Is the picture the right way round? Look at the film from above. The filled square belongs at the "
        "back on the left, and all of the border on the film.");
    while (true) {
      if (!light("border", kLight_s)) return Outcome::Skipped;
      const std::string seen = dialog_.ask_for_word(
          "The square was: right (back left), x (back right), y (front left), both (front right), again?",
          {"again", "right", "x", "y", "both"});
      if (seen == "right") return Outcome::Passed;
      if (seen != "again" && !set_and_take("mirror", mirrored(seen))) return Outcome::Skipped;
    }
  }
  // What turns that round, too.
  [[nodiscard]] std::string mirrored(const std::string& seen) const {
    const bool x = (is("mirror", "x") || is("mirror", "both")) != (seen == "x" || seen == "both");
    const bool y = (is("mirror", "y") || is("mirror", "both")) != (seen == "y" || seen == "both");
    return x && y ? "both" : x ? "x" : y ? "y" : "none";
  }

  Outcome check_grid() {
    dialog_.say(
        "Is the picture undistorted? The grid has a line every 5 mm. All of them straight, its cells square, "
        "and as sharp in the corners as in the middle.");
    while (true) {
      if (!light("grid", kLight_s)) return Outcome::Skipped;
      const std::string seen =
          dialog_.ask_for_word("The grid is right (yes), not square (bent), or not sharp (blurred)?",
                               {"again", "yes", "bent", "blurred"});
      if (seen == "yes") return Outcome::Passed;
      if (seen == "bent")
        dialog_.say(
            "Turn the projector's keystone correction off, and set it square to the film; then again.");
      if (seen == "blurred") dialog_.say("Turn the focus, and set it square to the film; then again.");
    }
  }

  Outcome check_pixels() {
    const double pitch = pixel_pitch_um(answers_);
    dialog_.say(
        "How large is a pixel? Measure the rulers of the pattern dimensions, on paper in the film's place.");
    if (!light("dimensions", kLight_s)) return Outcome::Skipped;
    const auto told =
        dialog_.ask_for_number("Up to which tick did you measure, mm (Enter: skip)?", 1, kMost_mm);
    if (!told) return Outcome::Skipped;
    const auto measured = dialog_.ask_for_number("How long is that, mm (Enter: skip)?", 1, kMost_mm);
    if (!measured) return Outcome::Skipped;
    const double now = pitch * *measured / *told;
    dialog_.say(fmt::format("A pixel is {:.6g} um.", now));
    if (*measured == *told) return Outcome::Passed;
    return set_and_take("pixel_pitch_um", fmt::format("{:.6g}", now)) ? Outcome::Passed : Outcome::Skipped;
  }

  Outcome check_light() {
    if (!light("white", kShortLight_s)) return Outcome::Skipped;
    return dialog_.ask_for_word("Did the light go off by itself, wholly (yes or no)?", {"yes", "no"}) == "yes"
               ? Outcome::Passed
               : Outcome::Skipped;
  }

  const SetupChecks& with_;
  SetupDialog& dialog_;
  Answers& answers_;
  std::map<std::string, std::string>& outcomes_;
  SetupDaemon daemon_;
};

const Checks::Check Checks::kAll[9] = {
    {"switch", "the limit switch", "contourctl switches", &Checks::check_switch},
    {"direction", "the motor's direction", "contourctl move --by 2 --unhomed", &Checks::check_direction},
    {"homing", "homing", "contourctl home", &Checks::check_homing},
    {"steps", "the length of a millimetre", "contourctl move --by 50, and a caliper", &Checks::check_steps},
    {"projector", "the projector's answers", "contourctl projector status", &Checks::check_projector},
    {"picture", "the picture's sides", "contourctl show border", &Checks::check_picture},
    {"grid", "the picture's shape", "contourctl show grid", &Checks::check_grid},
    {"pixels", "the pixels' size", "contourctl show dimensions", &Checks::check_pixels},
    {"light", "the light's end", "contourctl light on --seconds 2", &Checks::check_light},
};

}  // namespace

void check_printer(const SetupChecks& checks) {
  Checks(checks).run();
}

void expect_restart(SetupRecord& record) {
  record.checks[kConfiguration] = "written";
}

}  // namespace contourd::ctl
