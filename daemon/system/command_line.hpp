// Handles --help and invalid command lines for both programs. Only the source that parses the
// command line includes this header, because CLI11 takes longer to compile than most sources.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/nearest_word.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"

namespace contourd {

// Returns the program and its commands on the command line, from the first to the last.
inline std::vector<const CLI::App*> commands_on_line(const CLI::App& program) {
  std::vector<const CLI::App*> commands{&program};
  while (!commands.back()->get_subcommands().empty())
    commands.push_back(commands.back()->get_subcommands().back());
  return commands;
}

// Returns the long options of a command: "--json".
inline std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      names.push_back("--" + name);
  // A group of options is a command without a name.
  for (const CLI::App* below : command.get_subcommands({})) {
    if (!below->get_name().empty()) continue;
    const std::vector<std::string> grouped = options_of(*below);
    names.insert(names.end(), grouped.begin(), grouped.end());
  }
  return names;
}

// Returns the commands that --help lists.
inline std::vector<std::string> commands_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* below : command.get_subcommands({}))
    if (!below->get_name().empty() && !below->get_group().empty()) names.push_back(below->get_name());
  return names;
}

// Returns a sentence about an unknown command or option and the one that was probably meant, or an empty
// string if the word is neither.
inline std::string unknown_word(const std::vector<const CLI::App*>& commands, const CLI::App& command,
                                const std::string& word) {
  constexpr std::size_t kLongest = 60;
  if (!word.starts_with('-')) {
    const std::vector<std::string> known = commands_of(command);
    return known.empty()
               ? ""
               : fmt::format("unknown command {}{}", shortened(word, kLongest), suggestion(word, known));
  }
  const std::string name = word.substr(0, word.find('='));
  const std::vector<std::string> last = options_of(*commands.back());
  if (std::ranges::find(last, name) != last.end())
    return fmt::format("{} has to follow the command {}", name, commands.back()->get_name());
  const std::string dashed = (name.starts_with("--") ? "" : "-") + name;
  const std::string meant = suggestion(dashed, options_of(command));
  return meant.empty() ? "" : fmt::format("unknown option {}{}", name, meant);
}

// Returns the sentence about the first word that no command takes, or an empty string.
inline std::string unknown_word(const CLI::App& program) {
  const std::vector<const CLI::App*> commands = commands_on_line(program);
  for (const CLI::App* command : commands) {
    const std::vector<std::string> unknown = command->remaining();
    if (!unknown.empty()) return unknown_word(commands, *command, unknown.front());
  }
  return "";
}

// True if the command line ends where one of several commands has to follow.
inline bool lacks_command(const CLI::App& program) {
  const CLI::App& last = *commands_on_line(program).back();
  return last.get_require_subcommand_min() > 0 && last.remaining().empty();
}

// Prints the help or the usage error; where a command is missing, prints the help with the list of commands
// as the error. Returns the exit code.
inline int end_of_command_line(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream help, mistake;
  const bool good = app.exit(error, help, mistake) == 0;
  fmt::print("{}", help.str());
  if (good) return EXIT_SUCCESS;
  const std::string unknown = unknown_word(app);
  const std::string text = lacks_command(app) ? app.help()
                           : unknown.empty()  ? mistake.str()
                                              : unknown + "\nRun with --help for more information.\n";
  fmt::print(stderr, "{}", printable_lines(text));
  return kBadUsage;
}

}  // namespace contourd
