// Removes secrets and names from a text that a user shares with others. Thread-safe (no state).
#pragma once

#include <string>
#include <string_view>

namespace contourd::ctl {

// Returns the text with *** in place of each value after a word such as password, token, secret or key and
// ':' or '=' in its line, and of the names of users after /home/ and in "user NAME (NUMBER)".
[[nodiscard]] std::string without_private_words(std::string_view text);

}  // namespace contourd::ctl
