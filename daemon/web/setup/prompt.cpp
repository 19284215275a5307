#include "daemon/web/setup/prompt.hpp"

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

namespace contourd::web {
namespace {

// Keeps the terminal from showing what is typed.
class NoEcho {
 public:
  NoEcho() : works_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    termios quiet = before_;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    if (works_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet);
  }
  ~NoEcho() {
    if (works_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }
  NoEcho(const NoEcho&) = delete;
  NoEcho& operator=(const NoEcho&) = delete;

 private:
  termios before_{};
  bool works_;
};

}  // namespace

bool on_terminal() {
  return ::isatty(STDIN_FILENO) != 0;
}

std::string line_after(const char* prompt) {
  fmt::print(stderr, "{}", prompt);
  std::string line;
  std::getline(std::cin, line);
  return line;
}

std::optional<std::string> secret_after(const char* prompt) {
  if (!on_terminal()) return line_after("");
  const NoEcho quiet;
  std::string secret = line_after(prompt);
  const std::string again = line_after("\nThe same again: ");
  fmt::print(stderr, "\n");
  if (secret == again) return secret;
  fmt::print(stderr, "contourctl: the two passwords differ; nothing was changed\n");
  return std::nullopt;
}

}  // namespace contourd::web
