// Turns answers into a printer's configuration and into notes for its user. Pure functions; thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ctl/setup/setup_questions.hpp"

namespace contourd::ctl {

// Returns the answers to questions that apply.
[[nodiscard]] Answers asked_answers(const Answers& answers, const SetupFacts& facts);

// Returns the configuration `base` with the answers in it. `base` is complete, real or simulated; its keys
// without a question keep their values. REQUIRES: the answers are from asked_answers(), with an answer to
// every question that applies.
[[nodiscard]] nlohmann::ordered_json profile_of(const Answers& answers, nlohmann::ordered_json base);

struct ExplainedAnswer {
  std::string key, answer;
  std::string why;  // one clause
};
// Returns the answer to each question that applies, in the questions' order. All of them must have been
// answered.
[[nodiscard]] std::vector<ExplainedAnswer> explained(const Answers& answers, const SetupFacts& facts);

// Returns the questions with the explained answers, for a file next to the configuration, because JSON has no
// comments.
[[nodiscard]] std::string notes_of(const Answers& answers, const SetupFacts& facts,
                                   const std::string& config);

}  // namespace contourd::ctl
