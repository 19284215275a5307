#include "daemon/ctl/terminal/terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "daemon/ctl/terminal/text_columns.hpp"

namespace contourd::ctl {
namespace {

bool is_ignored(int signal) {
  struct sigaction action {};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

bool knows_sequences() {
  const char* const terminal = std::getenv("TERM");
  const std::string_view name = terminal != nullptr ? terminal : "";
  return ::isatty(STDOUT_FILENO) != 0 && !name.empty() && name != "dumb";
}

bool wants_colors() {
  const char* const no_color = std::getenv("NO_COLOR");
  return no_color == nullptr || *no_color == '\0';
}

bool in_foreground() {
  const pid_t group = ::tcgetpgrp(STDOUT_FILENO);
  return group < 0 || group == ::getpgrp();
}

FileDescriptor open_output_without_waiting() {
  return FileDescriptor(::open("/proc/self/fd/1", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
}

sigset_t ending_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP})
    if (!is_ignored(signal)) ::sigaddset(&set, signal);
  return set;
}

HeldSignals::HeldSignals() {
  sigset_t held = ending_signals();
  waiting_ = FileDescriptor(::signalfd(-1, &held, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!waiting_.valid()) throw std::system_error(errno, std::generic_category(), "cannot wait for signals");
  ::sigaddset(&held, SIGTTOU);
  ::sigprocmask(SIG_BLOCK, &held, &before_);
}

HeldSignals::~HeldSignals() {
  ::sigprocmask(SIG_SETMASK, &before_, nullptr);
}

int terminal_columns() {
  constexpr int kUsual = 80;
  winsize size{};
  const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kUsual;
}

void print_wrapped(std::string_view label, std::string_view text) {
  if (::isatty(STDOUT_FILENO) == 0) return fmt::print("{}{}\n", label, text);
  constexpr std::size_t kIndent = 2;
  const auto columns = static_cast<std::size_t>(std::max(terminal_columns(), 1));
  const bool beside = columns_of(label) * 3 <= columns;
  const std::size_t indent = beside ? columns_of(label) : std::min(kIndent, columns - 1);
  const std::string all = beside ? std::string(text) : fmt::format("{}{}", label, text);
  const std::string before(indent, ' ');
  std::string_view start = beside ? label : std::string_view();
  for (const std::string& line : wrapped(all, columns - indent))
    fmt::print("{}{}\n", std::exchange(start, before), line);
}

}  // namespace contourd::ctl
