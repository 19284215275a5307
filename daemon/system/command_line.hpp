// Handles --help and invalid command lines for both programs. Only main.cpp includes this header, because
// CLI11 takes longer to compile than most sources.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"

namespace contourd {

// Prints the help or the usage error. Returns the exit code.
inline int end_of_command_line(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream help, mistake;
  const bool good = app.exit(error, help, mistake) == 0;
  fmt::print("{}", help.str());
  fmt::print(stderr, "{}", printable_lines(mistake.str()));
  return good ? EXIT_SUCCESS : kBadUsage;
}

}  // namespace contourd
