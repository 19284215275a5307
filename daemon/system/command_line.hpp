// What both programs do with a command line that asks for help or cannot be used.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "daemon/system/printable.hpp"

namespace contourd {

// Of BSD's sysexits.h: EX_USAGE.
inline constexpr int kBadUsage = 64;

// Prints the help, or what is wrong. Returns the exit code.
inline int end_of_command_line(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream help, mistake;
  const bool good = app.exit(error, help, mistake) == 0;
  fmt::print("{}", help.str());
  fmt::print(stderr, "{}", printable_lines(mistake.str()));
  return good ? EXIT_SUCCESS : kBadUsage;
}

}  // namespace contourd
