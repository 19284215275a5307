#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/ctl/commands/help_page_text.hpp"
#include "daemon/ctl/commands/help_topics.hpp"
#include "daemon/ctl/terminal/command_line.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/markdown_text.hpp"
#include "daemon/ctl/terminal/program.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::ctl {
namespace {

using Topics = std::span<const HelpTopic* const>;

// The pages in the order in which a user needs them.
std::array<HelpPage, 10> pages() {
  return {{{"first-print", first_print_page},
           {"printing", printing_page},
           {"printer-setup", printer_setup_page},
           {"configuration", configuration_page},
           {"safety", safety_page},
           {"trouble", trouble_page},
           {"maintenance", maintenance_page},
           {"connections", connections_page},
           {"control-api", control_api_page},
           {"glossary", glossary_page}}};
}

// Returns the width of the text: at most 100 columns, because longer lines are hard to read.
std::size_t columns() {
  constexpr int kNarrowest = 20, kWidest = 100;
  return static_cast<std::size_t>(std::clamp(terminal_columns(), kNarrowest, kWidest));
}

// Returns an in-memory file with the text, so that the pager can read at its own pace after contourctl has
// become the pager. Invalid if the file cannot be made.
FileDescriptor file_with(std::string_view text) {
  FileDescriptor file(::memfd_create("help", MFD_CLOEXEC));
  while (file.valid() && !text.empty()) {
    const ssize_t written = ::write(file.get(), text.data(), text.size());
    if (written <= 0) return {};
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::lseek(file.get(), 0, SEEK_SET) != 0) return {};
  return file;
}

// Shows the text as git does: PAGER is run by a shell, and LESS makes less quit if the text fits the screen.
void show(const std::string& text) {
  const char* const wanted = std::getenv("PAGER");
  const std::string pager = wanted != nullptr ? wanted : "pager";
  if (knows_sequences() && !pager.empty() && pager != "cat") {
    const FileDescriptor file = file_with(text);
    if (file.valid() && ::dup2(file.get(), STDIN_FILENO) == STDIN_FILENO) {
      (void)::setenv("LESS", "FRX", 0);
      become_program({"sh", "-c", pager});
    }
  }
  fmt::print("{}", text);
}

// Returns the first sentence after the page's heading.
std::string summary_of(const HelpTopic& page) {
  std::string words = page.text.substr(page.text.find("\n\n") + 2);
  words.resize(std::min(words.find("\n\n"), words.size()));
  std::ranges::replace(words, '\n', ' ');
  words.resize(std::min({words.find(". "), words.find_last_not_of('.') + 1, words.size()}));
  return plain_words(words);
}

std::string list_of(const HelpTopics& topics) {
  std::string text =
      "contourctl help TOPIC shows one of these pages or sections, or the sections that mention a word.\n"
      "contourctl help COMMAND shows the usage of a command.\n\n";
  for (const HelpTopic& topic : topics.all()) {
    if (topic.whole_page)
      text += fmt::format("  {:14} {}\n", topic.page, cut_to_columns(summary_of(topic), columns() - 17));
    else
      text += fmt::format("    {}\n", topic.title);
  }
  return text;
}

std::string see_also(Topics topics) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (const HelpTopic* topic : topics.subspan(0, std::min(topics.size(), kMost)))
    text += fmt::format("    contourctl help {}\n", typed(*topic));
  return text.empty() ? text : "\nSee also:\n\n" + text;
}

std::vector<std::string> names_of(const Command& program) {
  std::vector<std::string> names;
  for (const Command& each : program.commands)
    if (!each.hidden) names.push_back(each.name);
  return names;
}

// Shows the topic, or a list of the topics if there are no words; in a terminal through the user's pager.
// Returns the exit code. Throws UsageError if nothing matches the words.
int show_topic(const std::vector<std::string>& words, const Command& program) {
  const std::array shipped = pages();
  const HelpTopics topics(shipped);
  const std::string wanted = fmt::format("{}", fmt::join(words, " "));
  if (words.empty()) {
    show(list_of(topics));
    return kOk;
  }
  const std::string command = usage_of(program, words);
  const std::vector<const HelpTopic*> found = topics.find(wanted);
  if (!command.empty()) {
    show(command + see_also(found));
  } else if (!found.empty()) {
    const HelpTopic& topic = *found.front();
    const Topics others = topic.whole_page ? Topics() : Topics(found).subspan(1);
    show(plain_text(topic.text, columns()) + see_also(others));
  } else {
    const std::vector<std::string> names = topics.nearest(wanted, names_of(program));
    const std::string similar = names.empty() ? "" : fmt::format("similar: {}; ", fmt::join(names, ", "));
    throw UsageError(
        fmt::format("no page mentions {}; {}contourctl help lists the topics", in_quotes(wanted), similar));
  }
  return kOk;
}

}  // namespace

void add_help(Command& program) {
  Command& command = program.add("help", "Show a page of the manual or the usage of a command");
  auto& topic = command.arguments<std::vector<std::string>>();
  command.option("TOPIC", topic, "Page, section, word or command; without it, a list")
      .allow_empty()
      .suggests([&program] {
        std::vector<std::string> topics;
        for (const HelpPage& page : pages())
          topics.emplace_back(page.name);
        std::ranges::move(names_of(program), std::back_inserter(topics));
        return topics;
      });
  command.run = [&program, &topic] { return show_topic(topic, program); };
}

}  // namespace contourd::ctl
