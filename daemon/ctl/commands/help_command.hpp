// contourctl help: shows the manual page and the usage of commands.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace contourd::ctl {

// Returns the help text of the command with these words, of contourctl itself for no words, or an empty
// string if there is no such command.
using HelpText = std::function<std::string(std::span<const std::string> words)>;

// Without words, runs man(1) for contourctl's manual page; if that is missing, prints contourctl's help text.
// With the words of a command, prints the command's help text. Returns the exit code. Throws UsageError if
// there is no such command, and std::system_error if man cannot be run.
int help(const std::vector<std::string>& words, const HelpText& text_of);

}  // namespace contourd::ctl
