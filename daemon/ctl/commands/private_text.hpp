// What is struck out of a text before its owner shows it to others. Thread-safe (no state).
#pragma once

#include <string>
#include <string_view>

namespace contourd::ctl {

// Line by line: what stands behind a word such as password, token, secret or key and a ':' or '='; the names
// of users below /home and in "user NAME (NUMBER)".
[[nodiscard]] std::string without_private_words(std::string_view text);

}  // namespace contourd::ctl
