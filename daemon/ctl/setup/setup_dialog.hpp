// What contourctl setup says and asks, line by line on standard output and input. Not thread-safe.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/ctl/setup/setup_profile.hpp"
#include "daemon/ctl/setup/setup_questions.hpp"

namespace contourd::ctl {

// Whoever answers wants to leave, or is gone.
struct SetupLeft {};

// Standard input, line by line. What is longer than any answer is cut.
class LineInput {
 public:
  // Blocks. Nothing at the end of the input.
  [[nodiscard]] std::optional<std::string> line();
  // Whether line() would not block by then.
  [[nodiscard]] bool wait(std::chrono::milliseconds time);

 private:
  bool read_more();

  std::string read_;
  bool ended_ = false;
};

class SetupDialog {
 public:
  // A paragraph, as wide as the terminal and no wider than people read; later lines begin with so many
  // spaces.
  void say(std::string_view text, std::size_t indent = 0) const;

  // One line. Throws SetupLeft at `quit` and at the end of the input.
  [[nodiscard]] std::string ask(std::string_view prompt);
  // For one of the words, until it is; an empty line is the first of them.
  [[nodiscard]] std::string ask_for_word(std::string_view prompt, const std::vector<std::string>& words);
  // For a number; nothing for an empty line.
  [[nodiscard]] std::optional<double> ask_for_number(std::string_view prompt, double least, double most);
  // Whether something was typed by then; it is read, and forgotten.
  [[nodiscard]] bool typed_within(std::chrono::milliseconds time);

  // Asks what is asked and has no good answer yet, from there on, and calls `kept` behind each answer. `back`
  // goes to the question before, and asks that again. Throws SetupLeft.
  void answer_all(Answers& answers, const SetupFacts& facts, const std::function<void()>& kept);
  // Asks that one again, then what has no good answer now.
  void answer_again(std::string_view key, Answers& answers, const SetupFacts& facts,
                    const std::function<void()>& kept);

 private:
  void answer_from(std::size_t again, Answers& answers, const SetupFacts& facts,
                   const std::function<void()>& kept);
  // False: back to the one before.
  bool answer_one(const Question& question, Answers& answers, const SetupFacts& facts);
  LineInput input_;
};

}  // namespace contourd::ctl
