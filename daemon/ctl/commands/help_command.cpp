#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <system_error>
#include <vector>

#include "daemon/ctl/terminal/command_line.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/program.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd::ctl {
namespace {

// True if man is installed and finds the page.
bool has_manual_page() {
  constexpr std::size_t kLongestPath = 4096;
  try {
    return run_program({"man", "-w", "contourctl"}, kLongestPath).text.starts_with('/');
  } catch (const std::system_error&) {
    return false;
  }
}

// Without words, runs man(1) for contourctl's manual page; if that is missing, prints contourctl's help text.
// With the words of a command, prints the command's help text. Throws UsageError if there is no such command.
int show_help(const std::vector<std::string>& words, const Command& program) {
  if (words.empty() && has_manual_page()) become_program({"man", "contourctl"});
  const std::string text = usage_of(program, words);
  if (text.empty()) {
    throw UsageError(fmt::format("there is no command {}; contourctl --help lists the commands",
                                 in_quotes(fmt::format("{}", fmt::join(words, " ")))));
  }
  fmt::print("{}\nManual: man contourctl, man contourd, man contourd.json; guides: {}\n", text,
             CONTOURD_GUIDES);
  return kOk;
}

}  // namespace

void add_help(Command& program) {
  Command& command = program.add("help", "Show the manual page, or the usage of a command");
  auto& words = command.arguments<std::vector<std::string>>();
  command.option("COMMAND", words, "Show the usage of this command").allow_empty().suggests([&program] {
    std::vector<std::string> names;
    for (const Command& each : program.commands)
      if (!each.hidden) names.push_back(each.name);
    return names;
  });
  command.run = [&program, &words] { return show_help(words, program); };
}

}  // namespace contourd::ctl
