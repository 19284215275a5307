// What contourctl setup asks: each question with its default, the reason for that, and what is no answer.
// Pure functions of what was found and what was answered before. Thread-safe.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "daemon/ctl/setup/machine_devices.hpp"
#include "daemon/ctl/setup/setup_answers.hpp"

namespace contourd::ctl {

// What is known when a question is asked.
struct SetupFacts {
  MachineDevices devices;
  std::map<std::string, bool> tables = {};  // of projectors, by name: whether it switches the light
  std::string name = {};                    // the printer's, where the configuration has one
};

struct Suggestion {
  std::string answer;
  std::string why;   // one clause
  bool safe = true;  // may be taken where nobody can be asked
};

// What was typed, as it is kept; or a sentence that says why it is no answer.
struct TakenAnswer {
  std::string answer;
  std::string complaint;
};

struct Question {
  std::string_view key;
  std::string_view text;
  // False: what was answered before makes it pointless.
  std::function<bool(const Answers&, const SetupFacts&)> is_asked;
  std::function<Suggestion(const Answers&, const SetupFacts&)> suggest;
  std::function<TakenAnswer(const std::string& typed, const Answers&, const SetupFacts&)> take;
};

// In their order: each builds on answers to those before it that are asked.
[[nodiscard]] std::span<const Question> questions();
[[nodiscard]] const Question* find_question(std::string_view key);
// "name, travel_mm, ..."
[[nodiscard]] std::string question_keys();

// Of the answers. REQUIRES: those that it comes from are there, and good.
[[nodiscard]] double microsteps_per_mm(const Answers& answers);
[[nodiscard]] double pixel_pitch_um(const Answers& answers);
struct DisplayMode {
  int width_px = 0, height_px = 0;
  double refresh_hz = 0;
};
[[nodiscard]] DisplayMode display_mode(const Answers& answers);

}  // namespace contourd::ctl
