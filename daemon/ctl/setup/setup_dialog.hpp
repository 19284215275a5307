// The dialog of contourctl setup, line by line on standard output and input. Not thread-safe.
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

// Thrown when the user quits, or when standard input ends.
struct SetupLeft {};

// Reads standard input line by line. Lines that are longer than any answer are cut.
class LineInput {
 public:
  // Blocks until there is a line. Returns nullopt at the end of the input.
  [[nodiscard]] std::optional<std::string> line();
  // Waits at most this time. True if line() would not block.
  [[nodiscard]] bool wait(std::chrono::milliseconds time);

 private:
  bool read_more();

  std::string read_;
  bool ended_ = false;
};

class SetupDialog {
 public:
  // Prints a paragraph, wrapped to the terminal's width (at most 100 columns). Lines after the first are
  // indented by `indent` spaces.
  void say(std::string_view text, std::size_t indent = 0) const;

  // Asks for one line. This and the next functions throw SetupLeft on `quit` and at the end of the input.
  [[nodiscard]] std::string ask(std::string_view prompt);
  // Asks until the answer is one of the words or its beginning. An empty line selects the first word.
  [[nodiscard]] std::string ask_for_word(std::string_view prompt, const std::vector<std::string>& words);
  // Asks until the answer is a number within the limits. Returns nullopt for an empty line.
  [[nodiscard]] std::optional<double> ask_for_number(std::string_view prompt, double least, double most);
  // Waits at most this time for a line, and discards it. True if there was one.
  [[nodiscard]] bool typed_within(std::chrono::milliseconds time);

  // Asks each applicable question that has no valid answer yet, and calls `kept` after each answer. `back`
  // returns to the previous question. Throws SetupLeft.
  void answer_all(Answers& answers, const SetupFacts& facts, const std::function<void()>& kept);
  // Asks this question again, then each question that now has no valid answer. Throws SetupLeft.
  void answer_again(std::string_view key, Answers& answers, const SetupFacts& facts,
                    const std::function<void()>& kept);

 private:
  void answer_from(std::size_t again, Answers& answers, const SetupFacts& facts,
                   const std::function<void()>& kept);
  // Asks one question. Returns false if the user wants the previous question.
  bool answer_one(const Question& question, Answers& answers, const SetupFacts& facts);
  LineInput input_;
};

}  // namespace contourd::ctl
