// Questions to the user of a command that sets the page up. Thread-safe (no state), but there is one
// terminal.
#pragma once

#include <optional>
#include <string>

namespace contourd::web {

// True if standard input is a terminal, so that the command may ask.
[[nodiscard]] bool on_terminal();
// Prints the prompt to stderr and returns a line of standard input; empty at its end.
[[nodiscard]] std::string line_after(const char* prompt);
// Asks for a secret: on a terminal twice and without echo, otherwise by a line of standard input. Returns
// nullopt if both differ, with a sentence on stderr.
[[nodiscard]] std::optional<std::string> secret_after(const char* prompt);

}  // namespace contourd::web
