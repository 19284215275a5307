// The dialog of contourctl setup, which asks its questions. Not thread-safe.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "daemon/ctl/setup/setup_questions.hpp"
#include "daemon/ctl/terminal/dialog.hpp"

namespace contourd::ctl {

class SetupDialog : public Dialog {
 public:
  // Asks each applicable question that has no valid answer yet, and calls `kept` after each answer. `back`
  // returns to the previous question. Throws DialogLeft.
  void answer_all(Answers& answers, const SetupFacts& facts, const std::function<void()>& kept);
  // Asks this question again, then each question that now has no valid answer. Throws DialogLeft.
  void answer_again(std::string_view key, Answers& answers, const SetupFacts& facts,
                    const std::function<void()>& kept);

 private:
  void answer_from(std::size_t again, Answers& answers, const SetupFacts& facts,
                   const std::function<void()>& kept);
  // Asks one question. Returns false if the user wants the previous question.
  bool answer_one(const Question& question, Answers& answers, const SetupFacts& facts);
};

}  // namespace contourd::ctl
