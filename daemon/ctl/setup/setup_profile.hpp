// From answers to a printer's configuration, and to what its owner is told of it. Pure functions;
// thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ctl/setup/setup_questions.hpp"

namespace contourd::ctl {

// Those of questions that are asked.
[[nodiscard]] Answers asked_answers(const Answers& answers, const SetupFacts& facts);

// The configuration with what was answered in it. `base` is a whole one, real or simulated; what nobody was
// asked for stays as it is there. REQUIRES: asked_answers(), and one of each question that is asked.
[[nodiscard]] nlohmann::ordered_json profile_of(const Answers& answers, nlohmann::ordered_json base);

struct ExplainedAnswer {
  std::string key, answer;
  std::string why;  // one clause
};
// Of each question that is asked, in their order; all of them have been answered.
[[nodiscard]] std::vector<ExplainedAnswer> explained(const Answers& answers, const SetupFacts& facts);

// The same with the questions, as the file that stays beside the configuration, since JSON has no comments.
[[nodiscard]] std::string notes_of(const Answers& answers, const SetupFacts& facts,
                                   const std::string& config);

}  // namespace contourd::ctl
