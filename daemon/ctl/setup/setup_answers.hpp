// What whoever brings a printer up has answered. Thread-safe (no shared state).
#pragma once

#include <map>
#include <optional>
#include <string>

namespace contourd::ctl {

// By the questions' keys; good ones are as setup_questions.hpp leaves them.
using Answers = std::map<std::string, std::string>;

// A finite number, and nothing else; a decimal point, no exponent needed.
[[nodiscard]] std::optional<double> number_of(const std::string& word);
// The answer as a number. REQUIRES: there is one, and it is a number.
[[nodiscard]] double number_in(const Answers& answers, const std::string& key);

}  // namespace contourd::ctl
