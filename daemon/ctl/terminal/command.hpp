// The description of contourctl's commands: names, help, options and functions. The parser of the command
// line, completion in a shell and the manual page's lists of options are made from it. Main thread only.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace contourd::ctl {

// An option or a positional argument of a command. An empty value is refused unless allow_empty() is called:
// an unset shell variable must not become 0 or "no output".
struct Option {
  // The variable that gets the value; a bool makes the option a flag. Its value beforehand is the default.
  using Variable =
      std::variant<bool*, int*, double*, std::string*, std::filesystem::path*, std::optional<int>*,
                   std::optional<double>*, std::optional<std::string>*, std::optional<std::filesystem::path>*,
                   std::vector<std::string>*, std::vector<std::filesystem::path>*>;
  // Returns values for completion in a shell.
  using Suggestions = std::function<std::vector<std::string>()>;

  std::string name;  // "--json", "-o,--output", or "MODEL" for a positional argument
  Variable variable;
  std::string help;
  bool is_required = false;
  bool may_be_empty = false;
  std::vector<std::string> choices{};           // the only valid values; empty: any value
  std::optional<std::pair<int, int>> limits{};  // smallest and largest value
  std::vector<const Option*> needed{}, excluded{};
  std::string group{};                       // exactly one option of a group is given
  Suggestions suggest{};                     // empty: none
  std::vector<std::string> file_suffixes{};  // completion offers only files with one of these suffixes

  Option& required() { return set(is_required, true); }
  Option& allow_empty() { return set(may_be_empty, true); }
  Option& one_of(std::vector<std::string> values) { return set(choices, std::move(values)); }
  Option& from_to(int least, int most) { return set(limits, std::pair(least, most)); }
  Option& in_group(std::string name_of_group) { return set(group, std::move(name_of_group)); }
  Option& needs(const Option& other) {
    needed.push_back(&other);
    return *this;
  }
  Option& excludes(const Option& other) {
    excluded.push_back(&other);
    return *this;
  }
  // Makes completion offer these values, and files with the suffixes, if any are given.
  Option& suggests(Suggestions values, std::vector<std::string> suffixes = {}) {
    return set(suggest, std::move(values)).set(file_suffixes, std::move(suffixes));
  }

  [[nodiscard]] bool is_flag() const { return holds<bool>(); }
  [[nodiscard]] bool is_positional() const { return !name.starts_with('-'); }
  // True if the option can be given several times, or the positional argument has several values.
  [[nodiscard]] bool is_list() const {
    return holds<std::vector<std::string>, std::vector<std::filesystem::path>>();
  }
  [[nodiscard]] bool is_path() const {
    return holds<std::filesystem::path, std::optional<std::filesystem::path>,
                 std::vector<std::filesystem::path>>();
  }
  // Returns the name without the short one: "--output" of "-o,--output".
  [[nodiscard]] std::string long_name() const { return name.substr(name.find(',') + 1); }

  // True if the variable has one of these types.
  template <typename... Types>
  [[nodiscard]] bool holds() const {
    return (std::holds_alternative<Types*>(variable) || ...);
  }

 private:
  template <typename Field, typename Value>
  Option& set(Field& field, Value value) {
    field = std::move(value);
    return *this;
  }
};

// The program, a command, or a group of commands such as `light`.
struct Command {
  std::string name, help;
  std::string version{};          // of the program: the answer to --version
  std::string group{};            // heading of --help above the command; empty: that of all commands
  bool hidden = false;            // not in the list of commands: it is for programs
  std::function<int()> run{};     // returns the exit code; empty if one of the commands below has to be given
  std::list<Option> options{};    // in the order of --help
  std::list<Command> commands{};  // in the order of --help
  std::vector<std::shared_ptr<void>> variables{};  // of the options: see arguments()

  Command& add(std::string command, std::string text) {
    return commands.emplace_back(Command{.name = std::move(command), .help = std::move(text)});
  }
  // Adds an option. The variable must outlive the command: see arguments().
  template <typename Variable>
  Option& option(std::string option, Variable& variable, std::string text) {
    return options.emplace_back(Option{std::move(option), &variable, std::move(text)});
  }
  // Returns variables for the options, which live as long as the command.
  template <typename Arguments>
  Arguments& arguments() {
    const auto made = std::make_shared<Arguments>();
    variables.push_back(made);
    return *made;
  }
  // Returns the command of this name, or null.
  [[nodiscard]] const Command* find(std::string_view command) const {
    const auto found = std::ranges::find(commands, command, &Command::name);
    return found == commands.end() ? nullptr : &*found;
  }
};

}  // namespace contourd::ctl
