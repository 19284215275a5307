// Finds the word that a person probably meant by a mistyped one. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace contourd {

// Returns the known word that differs from `typed` by the fewest typing mistakes, or nullopt if all of them
// differ too much. A mistake is a wrong, missing, additional or exchanged character; a word that was typed in
// part counts as one mistake. Of equally near words, returns the first.
[[nodiscard]] std::optional<std::string> nearest_word(std::string_view typed,
                                                      std::span<const std::string> known);

// Returns "; did you mean WORD?" with that word, or an empty string.
[[nodiscard]] std::string suggestion(std::string_view typed, std::span<const std::string> known);

}  // namespace contourd
