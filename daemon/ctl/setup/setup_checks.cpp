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

namespace contourd::ctl {
namespace {

using Json = SetupDaemon::Json;
using namespace std::chrono_literals;

constexpr const char* kConfiguration = "configuration";
constexpr const char* kPassed = "passed";
constexpr auto kAskInterval = 100ms;
constexpr double kLight_s = 5;       // long enough to examine a picture
constexpr double kShortLight_s = 2;  // for the check that the light goes off
constexpr double kMost_mm = 500;

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
      const bool passed = running && make(check);
      outcomes_[check.name] = passed ? kPassed : "skipped";
      with_.keep();
    }
    print_end();
  }

 private:
  struct Check {
    const char* name;
    const char* what;
    const char* later;
    bool (Checks::*make)();  // true: passed; false: skipped
  };
  static const Check kAll[9];

  [[nodiscard]] bool is(const char* key, const char* answer) const {
    const auto found = answers_.find(key);
    return found != answers_.end() && found->second == answer;
  }
  [[nodiscard]] bool applies(const Check& check) const {
    return std::string_view(check.name) != "projector" || !is("projector_table", "none");
  }

  // Makes a check. If the daemon fails, prints the reason and offers another try. Returns false if the user
  // skips the check.
  bool make(const Check& check) {
    fmt::print("\n");
    dialog_.say(fmt::format("Check: {}.", check.what));
    while (true) {
      try {
        return (this->*check.make)();
      } catch (const DaemonError& error) {
        dialog_.say(fmt::format("{}.", error.what()));
      }
      if (dialog_.ask_for_word("Enter: try again; skip:", {"again", "skip"}) == "skip") return false;
    }
  }

  void print_end() {
    fmt::print("\n");
    std::string skipped;
    for (const Check& check : kAll) {
      if (!applies(check) || outcomes_[check.name] == kPassed) continue;
      if (skipped.empty()) dialog_.say("Not checked:");
      skipped = check.later;
      dialog_.say(fmt::format("  {}: {}", check.what, check.later), 4);
    }
    if (skipped.empty()) dialog_.say("All checks passed.");
    if (outcomes_[kConfiguration] == "written")
      dialog_.say("Apply the configuration with: sudo systemctl reload-or-restart contourd");
    dialog_.say("Next: sudo contourctl level, to level the plate; then docs/printing.md.");
  }

  // Restarts contourd if it does not run with the configuration as written. Returns false if the user skips
  // the restart.
  bool take_configuration() {
    if (outcomes_[kConfiguration] != "written") return true;
    if (!daemon_.restart(with_.config, answers_.at("name"))) return false;
    outcomes_[kConfiguration] = "taken";
    with_.keep();
    return true;
  }
  // Changes an answer, writes the configuration and restarts contourd with it. Returns false if the
  // configuration would not be valid (the answer is then unchanged), or if the user skips the restart.
  bool set_and_take(const char* key, const std::string& answer) {
    const Answers before = answers_;
    answers_[key] = answer;
    if (with_.write()) return take_configuration();
    answers_ = before;
    return false;
  }
  bool skips(const std::string& prompt) { return dialog_.ask_for_word(prompt, {"go", "skip"}) == "skip"; }

  // --- the checks; each returns true if it has been passed, and false if it is skipped

  bool check_switch() {
    if (skips("Do not touch the switch. Enter: read its line; skip:")) return false;
    const Json rest = daemon_.limit_switch();
    const bool reached = rest["active"].get<bool>();
    dialog_.say(fmt::format("Its line is {}. Now press and release it by hand. Enter: skip.",
                            rest.value("line", "")));
    const auto edges = rest.value("edges", std::uint64_t{0});
    while (daemon_.limit_switch().value("edges", std::uint64_t{0}) == edges)
      if (dialog_.typed_within(kAskInterval)) return false;
    dialog_.say("Its line changes: the switch is wired.");
    if (!reached) return true;
    const char* const other = is("switch_contact", "normally_closed") ? "normally_open" : "normally_closed";
    dialog_.say(fmt::format(
        "But it read as reached while untouched, so its contact is {}: switch_contact is changed.", other));
    return set_and_take("switch_contact", other);
  }

  // Moves the plate by at most 2 mm, and only until the switch closes, because the direction and the length
  // of the motor's steps are not known yet.
  bool check_direction() {
    dialog_.say(
        "Which way does the plate move? Remove the vat, put the plate in the middle of its travel with "
        "nothing "
        "in its way, and keep a hand at the power switch. The plate moves up slowly, by 2 mm according to "
        "the "
        "answers so far, and stops at the switch.");
    while (true) {
      if (skips("Enter: move; skip:")) return false;
      daemon_.control("move", {{"by_mm", 2}, {"unhomed", true}, {"plate_is_clear", true}},
                      "The plate did not move");
      const std::string direction =
          dialog_.ask_for_word("It moved: up, down, or not at all (no)?", {"again", "up", "down", "no"});
      if (direction == "up") return true;
      if (direction == "no") {
        dialog_.say("Check the driver's supply, current, ENABLE and STEP, then try again.");
      } else if (direction == "down") {
        dialog_.say("DIR is inverted.");
        if (!set_and_take("direction_active_low", is("direction_active_low", "yes") ? "no" : "yes"))
          return false;
      }
    }
  }

  bool check_homing() {
    dialog_.say(
        "Does the plate stop at its switch? Put the switch and its plug back in place, remove the vat, make "
        "sure that nothing is on the plate or in its way, and keep a hand at the power switch.");
    constexpr int kTimes = 2;
    if (skips("Enter: home twice; skip:")) return false;
    for (int i = 0; i < kTimes; ++i) {
      daemon_.control("home", {{"plate_is_clear", true}}, "The plate was not homed");
      if (i + 1 < kTimes) daemon_.control("move", {{"to_mm", middle()}}, "The plate did not move");
    }
    const bool near = print_shift();
    const bool stopped =
        dialog_.ask_for_word("Did it stop at the switch both times (yes or no)?", {"yes", "no"}) == "yes";
    return near && stopped;
  }
  // Prints the shift of the switch, from the steps counted between both homings. Returns false if the shift
  // is too large for a working axis.
  bool print_shift() {
    const std::optional<double> shift = daemon_.by_hand("homing_shift_um");
    if (!shift) return true;
    constexpr double kLayer_um = 50;  // usual layer height
    dialog_.say(fmt::format("The switch was {}.", describe_homing_shift(*shift)));
    if (std::abs(*shift) <= kLayer_um) return true;
    dialog_.say(
        "This is more than a layer. The coupling or the switch may be loose, or the motor loses steps: raise "
        "its current, or lower homing_speed_mm_s or top_speed_mm_s.");
    return false;
  }
  [[nodiscard]] double middle() const { return std::min(20.0, number_in(answers_, "travel_mm") / 2); }

  // Moves the plate by a quarter of its travel, because the length of its steps is not known yet.
  bool check_steps() {
    if (!daemon_.by_hand("height_mm")) {
      dialog_.say("The plate's position is unknown: home it first.");
      return false;
    }
    const double travel = number_in(answers_, "travel_mm"), from = travel / 4, distance = travel / 4;
    if (skips(fmt::format("How long is a millimetre? Remove the vat. Enter: move the plate to {:g} mm; skip:",
                          from)))
      return false;
    daemon_.control("move", {{"to_mm", from}, {"plate_is_clear", true}}, "The plate did not move");
    (void)dialog_.ask(
        fmt::format("Measure the plate's height with a caliper. Enter: move {:g} mm further up.", distance));
    daemon_.control("move", {{"to_mm", from + distance}}, "The plate did not move");
    const auto measured =
        dialog_.ask_for_number("By how much did the plate rise, mm (Enter: skip)?", 0.1, kMost_mm);
    if (!measured) return false;
    const double before = microsteps_per_mm(answers_), now = before * distance / *measured;
    // Tolerance: the accuracy of a caliper over this distance.
    constexpr double kSame = 0.002;
    if (std::abs(now / before - 1) <= kSame) {
      dialog_.say(fmt::format("Correct: {:g} microsteps are a millimetre.", before));
      return true;
    }
    dialog_.say(fmt::format(
        "The plate should have risen {:g} mm: by this measurement, a millimetre is {:g} microsteps, "
        "not {:g}. If it is wrong by a factor such as 2 or 4, microsteps or screw_lead_mm is wrong; "
        "otherwise the measurement may be wrong.",
        distance, now, before));
    if (dialog_.ask_for_word("Change microsteps_per_mm accordingly (no or yes)?", {"no", "yes"}) == "no")
      return false;
    return set_and_take("microsteps_per_mm", fmt::format("{:.6g}", now));
  }

  bool check_projector() {
    if (skips("Enter: query the projector; skip:")) return false;
    daemon_.control("projector", Json::object(), "The projector does not answer as its table says");
    const Json status = daemon_.ask("status");
    const Json& projector = status["manual"]["projector"];
    if (!projector.is_object() || !projector["powered"].is_boolean()) {
      dialog_.say("Its table has no command that queries the power.");
      return false;
    }
    return true;
  }

  // Asks for permission, then lights the pattern. Returns false if the answer is no.
  bool light(const char* pattern, double seconds) {
    const std::string answer = dialog_.ask_for_word(
        fmt::format("UV light for {:g} s, with {}. No resin in the vat, eyes protected (no or yes)?", seconds,
                    pattern),
        {"no", "yes"});
    if (answer != "yes") return false;
    daemon_.light(pattern, seconds);
    return true;
  }

  bool check_picture() {
    dialog_.say(
        "Is the picture's orientation right? Look at the film from above: the filled square must be at the "
        "back left, and the whole border must be on the film.");
    while (true) {
      if (!light("border", kLight_s)) return false;
      const std::string seen = dialog_.ask_for_word(
          "The square was: right (back left), x (back right), y (front left), both (front right), again?",
          {"again", "right", "x", "y", "both"});
      if (seen == "right") return true;
      if (seen != "again" && !set_and_take("mirror", mirrored(seen))) return false;
    }
  }
  // Returns the value of `mirror` that corrects what the user has seen.
  [[nodiscard]] std::string mirrored(const std::string& seen) const {
    const bool x = (is("mirror", "x") || is("mirror", "both")) != (seen == "x" || seen == "both");
    const bool y = (is("mirror", "y") || is("mirror", "both")) != (seen == "y" || seen == "both");
    return x && y ? "both" : x ? "x" : y ? "y" : "none";
  }

  bool check_grid() {
    dialog_.say(
        "Is the picture undistorted? The grid has a line every 5 mm. All lines must be straight, the cells "
        "square, and the corners as sharp as the middle.");
    while (true) {
      if (!light("grid", kLight_s)) return false;
      const std::string seen =
          dialog_.ask_for_word("The grid is right (yes), not square (bent), or not sharp (blurred)?",
                               {"again", "yes", "bent", "blurred"});
      if (seen == "yes") return true;
      if (seen == "bent")
        dialog_.say(
            "Turn off the projector's keystone correction, and align the projector square to the film; then "
            "try again.");
      if (seen == "blurred")
        dialog_.say("Adjust the focus, and align the projector square to the film; then try again.");
    }
  }

  bool check_pixels() {
    const double pitch = pixel_pitch_um(answers_);
    dialog_.say(
        "How large is a pixel? Put paper in place of the film, and measure the rulers of the pattern "
        "dimensions.");
    if (!light("dimensions", kLight_s)) return false;
    const auto nominal =
        dialog_.ask_for_number("Up to which tick did you measure, mm (Enter: skip)?", 1, kMost_mm);
    if (!nominal) return false;
    const auto measured = dialog_.ask_for_number("How long is this distance, mm (Enter: skip)?", 1, kMost_mm);
    if (!measured) return false;
    const double now = pitch * *measured / *nominal;
    dialog_.say(fmt::format("A pixel is {:.6g} um.", now));
    if (*measured == *nominal) return true;
    return set_and_take("pixel_pitch_um", fmt::format("{:.6g}", now));
  }

  bool check_light() {
    if (!light("white", kShortLight_s)) return false;
    return dialog_.ask_for_word("Did the light go off by itself, completely (yes or no)?", {"yes", "no"}) ==
           "yes";
  }

  const SetupChecks& with_;
  Dialog& dialog_;
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
    {"picture", "the picture's orientation", "contourctl show border", &Checks::check_picture},
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
