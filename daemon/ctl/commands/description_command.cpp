#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <variant>
#include <vector>

#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/terminal/command_line.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/program.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/nearest_word.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

// The state of a command line before the word that is completed.
struct Typed {
  const Command* command = nullptr;
  const Option* option = nullptr;  // waits for its value
  std::size_t positionals = 0;
};

const Option* find_option(const Command& command, std::string_view name) {
  for (const Option& each : command.options)
    if (each.long_name() == name || each.name.substr(0, each.name.find(',')) == name) return &each;
  return nullptr;
}

// Returns the positional argument with this number, from 0; a list takes all further words.
const Option* positional(const Command& command, std::size_t number) {
  for (const Option& each : command.options) {
    if (!each.is_positional()) continue;
    if (number == 0 || each.is_list()) return &each;
    --number;
  }
  return nullptr;
}

void take(Typed& typed, const std::string& word) {
  if (typed.option != nullptr) {
    typed.option = nullptr;
  } else if (word.starts_with('-')) {
    typed.option = find_option(*typed.command, word);
    if (typed.option != nullptr && typed.option->is_flag()) typed.option = nullptr;
  } else if (const Command* below = typed.command->find(word); below != nullptr && typed.positionals == 0) {
    typed.command = below;
  } else {
    ++typed.positionals;
  }
}

void offer_word(std::string_view word, std::string_view begin, std::string_view help = "") {
  if (word.starts_with(begin)) fmt::print("{}{}{}\n", word, help.empty() ? "" : "\t", help);
}

void offer_values(const Option& option, std::string_view begin) {
  for (const std::string& each : option.choices)
    offer_word(each, begin);
  if (option.suggest) {
    for (const std::string& each : option.suggest())
      offer_word(each, begin);
  }
  // No other word begins with a slash.
  if (option.is_path()) fmt::print("/\n");
  for (const std::string& suffix : option.file_suffixes)
    fmt::print("/{}\n", suffix);
}

// Prints the words that can be the last one, one per line, each with a tab and its help if there is one. A
// line "/" stands for the names of files, and "/.stl" for the names of files with this suffix.
int complete(const Command& program, const std::vector<std::string>& words) {
  Typed typed{&program};
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    take(typed, words[i]);
  const std::string last = words.empty() ? "" : words.back();
  if (typed.option != nullptr) {
    offer_values(*typed.option, last);
  } else if (last.starts_with('-')) {
    for (const Option& each : typed.command->options)
      if (!each.is_positional()) offer_word(each.long_name(), last, each.help);
    offer_word("--help", last);
  } else if (const Option* argument = positional(*typed.command, typed.positionals); argument != nullptr) {
    offer_values(*argument, last);
  } else if (typed.positionals == 0) {
    for (const Command& each : typed.command->commands)
      if (!each.hidden) offer_word(each.name, last, each.help);
  }
  return kOk;
}

// Returns the word that stands for the option's value in the manual page; empty for a flag.
std::string placeholder(const Option& option) {
  if (option.is_flag()) return "";
  if (option.is_path()) return "FILE";
  if (option.holds<int, std::optional<int>>()) return "N";
  return option.holds<double, std::optional<double>>() ? "NUMBER" : "TEXT";
}

// Returns the option's default; empty if it has none.
std::string default_of(const Option& option) {
  if (option.is_required) return "";
  return std::visit(
      [](auto* variable) -> std::string {
        using Value = std::remove_pointer_t<decltype(variable)>;
        if constexpr (std::is_same_v<Value, std::filesystem::path>)
          return variable->string();
        else if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, double> ||
                           std::is_same_v<Value, std::string>)
          return fmt::format("{}", *variable);
        else
          return "";
      },
      option.variable);
}

void add_description(const Command& command, const std::string& words, Json& all) {
  Json options = Json::array();
  for (const Option& each : command.options)
    options.push_back({{"name", each.name},
                       {"value", placeholder(each)},
                       {"choices", each.choices},
                       {"required", each.is_required || !each.group.empty()},
                       {"list", each.is_list()},
                       {"default", default_of(each)},
                       {"help", each.help}});
  if (command.run)
    all.push_back({{"command", words}, {"help", command.help}, {"options", std::move(options)}});
  for (const Command& each : command.commands)
    if (!each.hidden) add_description(each, words + (words.empty() ? "" : " ") + each.name, all);
}

std::vector<std::string> command_names(const Command& program) {
  std::vector<std::string> names;
  for (const Command& each : program.commands)
    if (!each.hidden) names.push_back(each.name);
  return names;
}

// True if man is installed and finds the page.
bool has_manual_page() {
  constexpr std::size_t kLongestPath = 4096;
  try {
    return run_program({"man", "-w", "contourctl"}, kLongestPath).text.starts_with('/');
  } catch (const std::system_error&) {
    return false;
  }
}

// Returns the end of the sentence about an unknown command: the command that was probably meant, or the way
// to find it.
std::string meant_command(const std::vector<std::string>& words, const Command& program) {
  const Command* command = &program;
  for (const std::string& word : words) {
    const Command* const below = command->find(word);
    if (below == nullptr) {
      const std::string meant = suggestion(word, command_names(*command));
      if (!meant.empty()) return meant;
      break;
    }
    command = below;
  }
  return "; contourctl --help lists the commands";
}

// Without words, runs man(1) for contourctl's manual page; if that is missing, prints contourctl's help text.
// With the words of a command, prints the command's help text. Throws UsageError if there is no such command.
int show_help(const std::vector<std::string>& words, const Command& program) {
  if (words.empty() && has_manual_page()) become_program({"man", "contourctl"});
  const std::string text = usage_of(program, words);
  if (text.empty()) {
    throw UsageError(fmt::format("there is no command {}{}",
                                 in_quotes(fmt::format("{}", fmt::join(words, " "))),
                                 meant_command(words, program)));
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
    return command_names(program);
  });
  command.run = [&program, &words] { return show_help(words, program); };
}

void add_description(Command& program) {
  Command& completion = program.add("complete", "Print words that can follow, for completion in a shell");
  completion.hidden = true;
  auto& words = completion.arguments<std::vector<std::string>>();
  completion.option("WORD", words, "Words after contourctl; the last one is completed").allow_empty();
  completion.run = [&program, &words] { return complete(program, words); };
  Command& description =
      program.add("describe", "Print all commands and options as JSON, for the manual page");
  description.hidden = true;
  description.run = [&program] {
    Json all = Json::array();
    add_description(program, "", all);
    fmt::print("{}\n", all.dump(2));
    return kOk;
  };
}

}  // namespace contourd::ctl
