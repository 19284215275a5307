#include "daemon/ctl/watch/terminal_screen.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <system_error>

#include "daemon/ctl/terminal/terminal.hpp"

namespace contourd::ctl {
namespace {

// xterm's control sequences (ECMA-48 and the DEC private modes): alternate screen, cursor, line wrap. Line
// wrap is off, so that a character of unexpected width does not push the lines below it down.
constexpr std::string_view kEnter = "\x1B[?1049h\x1B[?25l\x1B[?7l\x1B[2J";
constexpr std::string_view kLeave = "\x1B[0m\x1B[?7h\x1B[?25h\x1B[?1049l";

enum PolledAt { kSignals, kKeys, kOut, kOther };

std::string_view sequence_of(Ink ink) {
  switch (ink) {
    case Ink::Plain:
      return "";
    case Ink::Strong:
      return "\x1B[1m";
    case Ink::Good:
      return "\x1B[32m";
    case Ink::Warning:
      return "\x1B[33m";
    case Ink::Alarm:
      return "\x1B[1;31m";
    case Ink::Faint:
      return "\x1B[2m";
  }
  return "";
}

FileDescriptor open_output() {
  FileDescriptor own = open_output_without_waiting();
  if (own.valid()) return own;
  return FileDescriptor(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0));
}

sigset_t handled_signals() {
  sigset_t set = ending_signals();
  ::sigaddset(&set, SIGWINCH);
  ::sigaddset(&set, SIGCONT);
  return set;
}

}  // namespace

TerminalScreen::TerminalScreen() : out_(open_output()), colors_(wants_colors()) {
  const sigset_t handled = handled_signals();
  signals_ = FileDescriptor(::signalfd(-1, &handled, SFD_CLOEXEC | SFD_NONBLOCK));
  if (signals_.get() < 0) throw std::system_error(errno, std::generic_category(), "cannot wait for signals");
  ::sigprocmask(SIG_BLOCK, &handled, &before_);
  enter();
}

TerminalScreen::~TerminalScreen() {
  leave();
  ::sigprocmask(SIG_SETMASK, &before_, nullptr);
}

ScreenSize TerminalScreen::size() const {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

void TerminalScreen::enter() {
  termios keyboard{};
  keyboard_.reset();
  if (::tcgetattr(STDIN_FILENO, &keyboard) == 0) {
    keyboard_ = keyboard;
    keyboard.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    // In the background, this stops the program until it is in the foreground again.
    (void)::tcsetattr(STDIN_FILENO, TCSANOW, &keyboard);
  }
  entered_ = true;
  pending_ += kEnter;
  drawn_.clear();
  flush();
}

void TerminalScreen::leave() noexcept {
  if (!entered_) return;
  entered_ = false;
  // The first byte (escape) ends an incomplete sequence or character.
  pending_.assign(kLeave);
  constexpr int kPatienceMs = 500;
  pollfd out{out_.get(), POLLOUT, 0};
  flush();
  if (!pending_.empty() && ::poll(&out, 1, kPatienceMs) > 0) flush();
  pending_.clear();
  if (!keyboard_) return;
  // SIGTTOU is blocked so that this works from the background, too.
  sigset_t output, before;
  ::sigemptyset(&output);
  ::sigaddset(&output, SIGTTOU);
  ::sigprocmask(SIG_BLOCK, &output, &before);
  (void)::tcsetattr(STDIN_FILENO, TCSANOW, &*keyboard_);
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
}

void TerminalScreen::draw(const std::vector<ScreenLine>& lines) {
  if (!entered_ || !pending_.empty()) return;
  if (drawn_.empty()) pending_ += "\x1B[2J";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i < drawn_.size() && drawn_[i] == lines[i]) continue;
    const std::string_view ink = colors_ ? sequence_of(lines[i].ink) : "";
    pending_ +=
        fmt::format("\x1B[{};1H\x1B[K{}{}{}", i + 1, ink, lines[i].text, ink.empty() ? "" : "\x1B[0m");
  }
  if (lines.size() < drawn_.size()) pending_ += fmt::format("\x1B[{};1H\x1B[J", lines.size() + 1);
  drawn_ = lines;
  flush();
}

void TerminalScreen::flush() noexcept {
  while (!pending_.empty()) {
    const ssize_t written = ::write(out_.get(), pending_.data(), pending_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EAGAIN) return;
    if (written < 0) return pending_.clear();  // the terminal is gone, SIGHUP follows
    pending_.erase(0, static_cast<std::size_t>(written));
  }
}

void TerminalScreen::wait(int other, int milliseconds) {
  polled_[kSignals] = {signals_.get(), POLLIN, 0};
  polled_[kKeys] = {keyboard_ && !keys_end_ ? STDIN_FILENO : -1, POLLIN, 0};
  polled_[kOut] = {pending_.empty() ? -1 : out_.get(), POLLOUT, 0};
  polled_[kOther] = {other, POLLIN, 0};
  if (::poll(polled_.data(), polled_.size(), milliseconds) < 0) {
    for (pollfd& each : polled_)
      each.revents = 0;
  }
}

std::optional<int> TerminalScreen::ended_by() {
  if (polled_[kOut].revents != 0) flush();
  if (polled_[kKeys].revents != 0) read_keys();
  signalfd_siginfo signal{};
  while (::read(signals_.get(), &signal, sizeof signal) == static_cast<ssize_t>(sizeof signal)) {
    const int number = static_cast<int>(signal.ssi_signo);
    if (number == SIGTSTP) {
      stop();
    } else if (number == SIGWINCH) {
      drawn_.clear();
    } else if (number == SIGCONT) {  // after a SIGSTOP, which cannot be handled
      leave();
      enter();
    } else {
      end_ = number;
    }
  }
  return end_;
}

void TerminalScreen::read_keys() {
  std::array<char, 64> keys;
  const ssize_t count = ::read(STDIN_FILENO, keys.data(), keys.size());
  keys_end_ = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
  if (count > 0 &&
      std::string_view(keys.data(), static_cast<std::size_t>(count)).find('q') != std::string_view::npos)
    end_ = kQuit;
  drawn_.clear();
}

// Restores the terminal, stops the program (SIGTSTP takes effect when it is unblocked), and enters the screen
// again when the program continues.
void TerminalScreen::stop() {
  leave();
  sigset_t stops;
  ::sigemptyset(&stops);
  ::sigaddset(&stops, SIGTSTP);
  (void)::kill(::getpid(), SIGTSTP);
  ::sigprocmask(SIG_UNBLOCK, &stops, nullptr);
  ::sigprocmask(SIG_BLOCK, &stops, nullptr);
  enter();
}

}  // namespace contourd::ctl
