#include "daemon/ctl/terminal/dialog.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <system_error>
#include <utility>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr std::array kSignals{SIGTERM, SIGHUP, SIGINT};

volatile std::sig_atomic_t signal_came = 0;

constexpr std::size_t kLongestLine = 1000;
constexpr std::size_t kWidestText = 100;  // longer lines are hard to read

constexpr std::size_t kRoomForAnswer = 8;  // columns after a prompt

std::size_t text_width() {
  return std::clamp(static_cast<std::size_t>(std::max(terminal_columns(), 0)), std::size_t{20}, kWidestText);
}

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\r"), to = text.find_last_not_of(" \t\r");
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}

bool quits(std::string_view answer) {
  return answer == "q" || answer == "quit";
}

}  // namespace

std::optional<double> number_of(const std::string& word) {
  double number = NAN;
  const char* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), end, number);
  if (read.ec != std::errc() || read.ptr != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

// --- LineInput

bool LineInput::read_more() {
  std::array<char, 4096> bytes{};
  ssize_t count = 0;
  do
    count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  while (count < 0 && errno == EINTR);
  if (count <= 0) ended_ = true;
  if (count > 0) read_.append(bytes.data(), static_cast<std::size_t>(count));
  return !ended_;
}

std::optional<std::string> LineInput::line() {
  std::size_t end = read_.find('\n');
  while (end == std::string::npos && read_more()) {
    end = read_.find('\n');
    if (end == std::string::npos && read_.size() > kLongestLine) read_.resize(kLongestLine);
  }
  if (end == std::string::npos) return std::nullopt;
  std::string text = read_.substr(0, std::min(end, kLongestLine));
  read_.erase(0, end + 1);
  return text;
}

bool LineInput::wait(std::chrono::milliseconds time) {
  if (ended_ || read_.find('\n') != std::string::npos) return true;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return ::poll(&input, 1, static_cast<int>(time.count())) > 0;
}

// --- Dialog

void Dialog::say(std::string_view text, std::size_t indent) const {
  const std::string margin(indent, ' ');
  std::string_view before;
  const std::size_t width = text_width();
  for (const std::string& line : wrapped(printable(text), width - std::min(indent, width / 2)))
    fmt::print("{}{}\n", std::exchange(before, margin), line);
  std::fflush(stdout);
}

std::string Dialog::ask(std::string_view prompt, std::string_view help) {
  while (true) {
    const std::vector<std::string> lines = wrapped(printable(prompt), text_width() - kRoomForAnswer);
    fmt::print("{} ", fmt::join(lines, "\n"));
    std::fflush(stdout);
    const std::optional<std::string> line = input_.line();
    if (!line) throw DialogLeft();
    if (::isatty(STDIN_FILENO) == 0) fmt::print("\n");
    std::string answer = trimmed(*line);
    if (quits(answer)) throw DialogLeft();
    if (answer != "?") return answer;
    say(help);
  }
}

std::string Dialog::ask_for_word(std::string_view prompt, const std::vector<std::string>& words) {
  const std::string expected =
      fmt::format("Expected one of: {}. Enter: {}; q quits.", fmt::join(words, ", "), words.front());
  while (true) {
    const std::string answer = ask(prompt, expected);
    if (answer.empty()) return words.front();
    const auto fits = [&](const std::string& word) { return word.starts_with(answer); };
    if (std::ranges::count_if(words, fits) == 1) return *std::ranges::find_if(words, fits);
    say(expected);
  }
}

std::optional<double> Dialog::ask_for_number(std::string_view prompt, double least, double most) {
  const std::string expected = fmt::format("Expected a number from {:g} to {:g}; q quits.", least, most);
  while (true) {
    const std::string answer = ask(prompt, expected);
    if (answer.empty()) return std::nullopt;
    const std::optional<double> number = number_of(answer);
    if (number && *number >= least && *number <= most) return number;
    say(expected);
  }
}

bool Dialog::typed_within(std::chrono::milliseconds time) {
  if (!input_.wait(time)) return false;
  const std::optional<std::string> line = input_.line();
  if (!line || quits(trimmed(*line))) throw DialogLeft();
  return true;
}

// --- keys

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
