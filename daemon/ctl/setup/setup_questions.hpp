// The questions of contourctl setup, each with its default, the reason for it, and a check of answers. Pure
// functions of the devices found and the answers so far. Thread-safe.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "daemon/ctl/setup/machine_devices.hpp"

namespace contourd::ctl {

// The user's answers, by the keys of their questions. Valid answers have the form that Question::take()
// returns.
using Answers = std::map<std::string, std::string>;

// Returns the answer as a number. REQUIRES: the question has been answered with a number.
[[nodiscard]] double number_in(const Answers& answers, const std::string& key);

// The facts that are known when a question is asked.
struct SetupFacts {
  MachineDevices devices;
  std::map<std::string, bool> tables = {};  // projector tables by name; true: the table switches the light
  std::string name = {};                    // name of the printer, if configured
};

struct Suggestion {
  std::string answer;
  std::string why;   // one clause
  bool safe = true;  // may be used without asking
};

// The result of typed text: an answer to store, or a complaint (a sentence) that says why it is not valid.
struct TakenAnswer {
  std::string answer;
  std::string complaint;
};

struct Question {
  std::string_view key;
  std::string_view text;
  // False if earlier answers make the question pointless.
  std::function<bool(const Answers&, const SetupFacts&)> is_asked;
  std::function<Suggestion(const Answers&, const SetupFacts&)> suggest;
  std::function<TakenAnswer(const std::string& typed, const Answers&, const SetupFacts&)> take;
};

// Returns the questions in their order: a question may use the answers to the questions before it.
[[nodiscard]] std::span<const Question> questions();
// Returns nullptr if no question has this key.
[[nodiscard]] const Question* find_question(std::string_view key);
// Returns "name, travel_mm, ...".
[[nodiscard]] std::string question_keys();

// Return values derived from the answers. REQUIRES: the answers from which the value derives exist and are
// valid.
[[nodiscard]] double microsteps_per_mm(const Answers& answers);
[[nodiscard]] double pixel_pitch_um(const Answers& answers);
struct DisplayMode {
  int width_px = 0, height_px = 0;
  double refresh_hz = 0;
};
[[nodiscard]] DisplayMode display_mode(const Answers& answers);

}  // namespace contourd::ctl
