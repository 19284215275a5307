// contourctl help. Prints its result and returns the exit code; a topic that there is none of comes out as
// UsageError.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace contourd::ctl {

// The commands, as the command line knows them.
struct CommandHelp {
  std::vector<std::string> names;
  // Of the command of these words; empty when there is none.
  std::function<std::string(std::span<const std::string> words)> of;
};

// A list of the topics where there are no words. In a terminal by the user's pager.
int help(const std::vector<std::string>& words, const CommandHelp& commands);

}  // namespace contourd::ctl
