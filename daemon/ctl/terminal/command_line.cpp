#include "daemon/ctl/terminal/command_line.hpp"

#include <CLI/CLI.hpp>
#include <map>
#include <string_view>
#include <type_traits>

#include "daemon/system/command_line.hpp"

namespace contourd::ctl {
namespace {

const CLI::Validator kNotEmpty([](const std::string& word) { return word.empty() ? "it is empty" : ""; }, "");

// CLI11's form of the description.
class Parser {
 public:
  explicit Parser(const Command& program) : app_(program.help, program.name) {
    app_.set_version_flag("--version", program.version);
    add_to(app_, program);
  }
  Parser(const Parser&) = delete;
  Parser& operator=(const Parser&) = delete;

  CLI::App& app() { return app_; }
  // Returns the command that parse() chose.
  [[nodiscard]] const Command& chosen() const { return *chosen_; }

 private:
  void add_to(CLI::App& app, const Command& command) {
    std::map<std::string_view, CLI::App*> groups;
    for (const Option& option : command.options) {
      CLI::App* owner = &app;
      if (!option.group.empty()) {
        owner = groups[option.group];
        if (owner == nullptr) {
          owner = groups[option.group] = app.add_option_group(option.group);
          owner->require_option(1);
        }
      }
      options_[&option] = add_option(*owner, option);
    }
    for (const Option& option : command.options) {
      for (const Option* other : option.needed)
        options_.at(&option)->needs(options_.at(other));
      for (const Option* other : option.excluded)
        options_.at(&option)->excludes(options_.at(other));
    }
    for (const Command& each : command.commands) {
      CLI::App* const below = app.add_subcommand(each.name, each.help);
      if (each.hidden || !each.group.empty()) below->group(each.hidden ? "" : each.group);
      add_to(*below, each);
    }
    if (!command.run) {
      app.require_subcommand(1);
    } else {
      // CLI11 calls this after the callback of a subcommand.
      app.callback([this, &app, &command] {
        if (app.get_subcommands().empty()) chosen_ = &command;
      });
    }
  }

  static CLI::Option* add_option(CLI::App& app, const Option& option) {
    CLI::Option* const added = std::visit(
        [&](auto* variable) -> CLI::Option* {
          if constexpr (std::is_same_v<decltype(variable), bool*>)
            return app.add_flag(option.name, *variable, option.help);
          else
            return app.add_option(option.name, *variable, option.help);
        },
        option.variable);
    if (option.is_required) added->required();
    if (option.is_flag()) return added;
    if (option.is_list() && !option.is_positional()) added->allow_extra_args(false);
    if (!option.is_list() && !option.is_required) added->capture_default_str();
    if (!option.may_be_empty) added->check(kNotEmpty);
    if (!option.choices.empty()) added->check(CLI::IsMember(option.choices));
    if (option.limits) added->check(CLI::Range(option.limits->first, option.limits->second));
    return added;
  }

  CLI::App app_;
  std::map<const Option*, CLI::Option*> options_;
  const Command* chosen_ = nullptr;
};

}  // namespace

int run_command_line(const Command& program, int argc, char** argv) {
  Parser parser(program);
  try {
    parser.app().parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_command_line(parser.app(), error);
  }
  return parser.chosen().run();
}

std::string usage_of(const Command& program, std::span<const std::string> words) {
  Parser parser(program);
  CLI::App* app = &parser.app();
  const Command* command = &program;
  std::string before;
  for (const std::string& word : words) {
    command = command->find(word);
    if (command == nullptr) return "";
    before += (before.empty() ? "" : " ") + app->get_name();
    app = app->get_subcommand(word);
  }
  return app->help(before);
}

}  // namespace contourd::ctl
