#include "daemon/ctl/terminal/command.hpp"

#include <algorithm>

namespace contourd::ctl {

Option& Option::required() {
  is_required = true;
  return *this;
}

Option& Option::allow_empty() {
  may_be_empty = true;
  return *this;
}

Option& Option::one_of(std::vector<std::string> values) {
  choices = std::move(values);
  return *this;
}

Option& Option::from_to(int least, int most) {
  limits = {least, most};
  return *this;
}

Option& Option::needs(const Option& other) {
  needed.push_back(&other);
  return *this;
}

Option& Option::excludes(const Option& other) {
  excluded.push_back(&other);
  return *this;
}

Option& Option::in_group(std::string name_of_group) {
  group = std::move(name_of_group);
  return *this;
}

Option& Option::suggests(Suggestions values, std::string suffix) {
  suggest = std::move(values);
  file_suffix = std::move(suffix);
  return *this;
}

bool Option::is_list() const {
  return std::holds_alternative<std::vector<std::string>*>(variable) ||
         std::holds_alternative<std::vector<std::filesystem::path>*>(variable);
}

bool Option::is_path() const {
  return std::holds_alternative<std::filesystem::path*>(variable) ||
         std::holds_alternative<std::optional<std::filesystem::path>*>(variable) ||
         std::holds_alternative<std::vector<std::filesystem::path>*>(variable);
}

Command& Command::add(std::string command, std::string text) {
  return commands.emplace_back(Command{.name = std::move(command), .help = std::move(text)});
}

const Command* Command::find(std::string_view command) const {
  const auto found = std::ranges::find(commands, command, &Command::name);
  return found == commands.end() ? nullptr : &*found;
}

}  // namespace contourd::ctl
