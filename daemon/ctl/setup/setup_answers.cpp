#include "daemon/ctl/setup/setup_answers.hpp"

#include <charconv>
#include <cmath>
#include <system_error>

#include "core/contract/expects.hpp"

namespace contourd::ctl {

std::optional<double> number_of(const std::string& word) {
  double number = NAN;
  const char* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), end, number);
  if (read.ec != std::errc() || read.ptr != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

double number_in(const Answers& answers, const std::string& key) {
  const auto answer = answers.find(key);
  expects(answer != answers.end(), "the question has been answered");
  const std::optional<double> number = number_of(answer->second);
  expects(number.has_value(), "the answer is a number");
  return *number;
}

}  // namespace contourd::ctl
