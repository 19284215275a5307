// contourctl help: shows pages of the manual and the usage of commands.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace contourd::ctl {

// The commands' names and help texts, as the command line parser knows them.
struct CommandHelp {
  std::vector<std::string> names;
  // Returns the help text of the command with these words, or an empty string if there is no such command.
  std::function<std::string(std::span<const std::string> words)> of;
};

// Shows the topic, or a list of the topics if there are no words; in a terminal through the user's pager.
// Returns the exit code. Throws UsageError if nothing matches the words.
int help(const std::vector<std::string>& words, const CommandHelp& commands);

}  // namespace contourd::ctl
