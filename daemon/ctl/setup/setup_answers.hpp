// The user's answers to the questions of contourctl setup. Thread-safe (no shared state).
#pragma once

#include <map>
#include <optional>
#include <string>

namespace contourd::ctl {

// Answers by the keys of their questions. Valid answers have the form that Question::take() returns.
using Answers = std::map<std::string, std::string>;

// Parses a finite number with a decimal point. Returns nullopt if the word is not exactly one number.
[[nodiscard]] std::optional<double> number_of(const std::string& word);
// Returns the answer as a number. REQUIRES: the question has been answered with a number.
[[nodiscard]] double number_in(const Answers& answers, const std::string& key);

}  // namespace contourd::ctl
