#include "daemon/system/nearest_word.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace contourd {
namespace {

constexpr std::size_t kLongestWord = 40;
constexpr std::size_t kShortestBeginning = 3;

// Returns the distance of optimal string alignment: changed, missing, additional and exchanged characters.
std::size_t mistakes_between(std::string_view typed, std::string_view word) {
  std::vector<std::size_t> before_last, last, row(word.size() + 1);
  for (std::size_t j = 0; j <= word.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= typed.size(); ++i) {
    before_last = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= word.size(); ++j) {
      const std::size_t changed = last[j - 1] + (typed[i - 1] == word[j - 1] ? 0 : 1);
      row[j] = std::min({changed, last[j] + 1, row[j - 1] + 1});
      const bool exchanged = i > 1 && j > 1 && typed[i - 1] == word[j - 2] && typed[i - 2] == word[j - 1];
      if (exchanged) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_word(std::string_view typed, std::span<const std::string> known) {
  if (typed.size() > kLongestWord) return std::nullopt;
  std::optional<std::string> nearest;
  std::size_t most = typed.size() < 3 ? 0 : 1 + typed.size() / 6;
  for (const std::string& word : known) {
    const bool begins = typed.size() >= kShortestBeginning && word.starts_with(typed);
    const std::size_t mistakes = begins ? 1 : mistakes_between(typed, word);
    if (mistakes > most || (nearest && mistakes == most)) continue;
    nearest = word;
    most = mistakes;
  }
  return nearest;
}

std::string suggestion(std::string_view typed, std::span<const std::string> known) {
  const std::optional<std::string> word = nearest_word(typed, known);
  return word ? fmt::format("; did you mean {}?", *word) : "";
}

}  // namespace contourd
