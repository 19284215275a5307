#include "daemon/ctl/terminal/command.hpp"

#include <algorithm>

namespace contourd::ctl {

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
