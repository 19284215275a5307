// The parser of contourctl's command line. It is the only source of contourctl that compiles CLI11, which
// takes longer to compile than most sources. Main thread only.
#pragma once

#include <span>
#include <string>

#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Parses the arguments and runs the chosen command. Prints the help or the usage error instead, if the
// arguments ask for help or are wrong. Returns the exit code; passes on the command's exceptions.
int run_command_line(const Command& program, int argc, char** argv);

// Returns the text of --help of the command with these words, of the program for no words, or an empty string
// if there is no such command.
[[nodiscard]] std::string usage_of(const Command& program, std::span<const std::string> words);

}  // namespace contourd::ctl
