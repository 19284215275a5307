#include "daemon/ctl/commands/help_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <system_error>

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

}  // namespace

int help(const std::vector<std::string>& words, const HelpText& text_of) {
  if (words.empty() && has_manual_page()) become_program({"man", "contourctl"});
  const std::string text = text_of(words);
  if (text.empty()) {
    throw UsageError(fmt::format("there is no command {}; contourctl --help lists the commands",
                                 in_quotes(fmt::format("{}", fmt::join(words, " ")))));
  }
  fmt::print("{}\nManual: man contourctl, man contourd, man contourd.json; guides: {}\n", text,
             CONTOURD_GUIDES);
  return kOk;
}

}  // namespace contourd::ctl
