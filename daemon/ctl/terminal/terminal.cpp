#include "daemon/ctl/terminal/terminal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"

namespace contourd::ctl {
namespace {

constexpr std::array kSignals{SIGTERM, SIGHUP, SIGINT};

volatile std::sig_atomic_t signal_came = 0;

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

std::optional<Key> take_key(std::string_view& sent) {
  constexpr char kEscape = '\x1b';
  if (sent.empty()) return std::nullopt;
  if (sent.front() != kEscape) {
    const Key key{sent.front(), {}};
    sent.remove_prefix(1);
    return key;
  }
  // A control sequence: CSI or SS3, parameters, a final letter (ECMA-48, 5.4).
  std::size_t length = 1;
  Key key;
  if (sent.size() > 1 && (sent[1] == '[' || sent[1] == 'O')) {
    length = 2;
    while (length < sent.size() && (sent[length] < '@' || sent[length] > '~'))
      ++length;
    if (length < sent.size()) {
      if (sent[length] == 'A') key.arrow = Arrow::Up;
      if (sent[length] == 'B') key.arrow = Arrow::Down;
      ++length;
    }
  }
  sent.remove_prefix(length);
  return key;
}

KeyInput::KeyInput(std::string_view what) {
  if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDOUT_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &before_) != 0)
    throw UsageError(fmt::format("{}: this needs a terminal", what));
  signal_came = 0;
  struct sigaction note {};
  note.sa_handler = [](int) { signal_came = 1; };  // no SA_RESTART: poll() returns
  for (const int number : kSignals)
    (void)::sigaction(number, &note, nullptr);
  termios keys = before_;
  keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG);
  keys.c_iflag &= ~static_cast<tcflag_t>(IXON);
  (void)::tcsetattr(STDIN_FILENO, TCSADRAIN, &keys);
}

KeyInput::~KeyInput() {
  (void)::tcsetattr(STDIN_FILENO, TCSADRAIN, &before_);
  for (const int number : kSignals)
    (void)std::signal(number, SIG_DFL);
}

std::string KeyInput::wait(int other) {
  std::array<pollfd, 2> waited{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{other, POLLIN, 0}};
  if (::poll(waited.data(), waited.size(), -1) <= 0 || waited[0].revents == 0) return {};
  std::array<char, 64> typed{};
  const ssize_t count = ::read(STDIN_FILENO, typed.data(), typed.size());
  if (count <= 0) closed_ = true;
  return count > 0 ? std::string(typed.data(), static_cast<std::size_t>(count)) : std::string();
}

bool KeyInput::ended() const {
  return closed_ || signal_came != 0;
}

}  // namespace contourd::ctl
