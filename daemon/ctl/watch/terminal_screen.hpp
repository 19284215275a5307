// The whole terminal for a view that is drawn in place: the alternate screen, without echo, until leave() or
// the destructor restores the terminal's previous contents. Signals that end or stop a program are blocked
// meanwhile and reported as events, so that the terminal is always restored. Never waits for a terminal that
// does not accept output. Not thread-safe; at most one object at a time.
#pragma once

#include <poll.h>
#include <termios.h>

#include <array>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/watch/watch_view.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

class TerminalScreen {
 public:
  static constexpr int kQuit = 0;

  TerminalScreen();
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  [[nodiscard]] ScreenSize size() const;

  // Shows these lines, made for size(), and clears the rows below. Draws nothing if the terminal has not yet
  // accepted earlier output.
  void draw(const std::vector<ScreenLine>& lines);

  // Waits until the terminal is ready, `other` is readable (-1: none) or the time has passed.
  void wait(int other, int milliseconds);
  // Handles the events since then: a change of size, a stop and its end. Returns the signal that ends the
  // view, or kQuit for the key q, if there was one.
  [[nodiscard]] std::optional<int> ended_by();

  // Restores the terminal. Does nothing if it has been restored.
  void leave() noexcept;

 private:
  void enter();
  void stop();
  void read_keys();
  // Writes pending output as far as the terminal accepts it, without waiting.
  void flush() noexcept;

  FileDescriptor out_;
  FileDescriptor signals_;
  sigset_t before_{};
  std::optional<termios> keyboard_;  // modes to restore
  bool entered_ = false;
  bool colors_;
  bool keys_end_ = false;  // standard input has ended
  std::optional<int> end_;
  std::string pending_;            // output that the terminal has not accepted yet
  std::vector<ScreenLine> drawn_;  // lines on the screen, which need no redrawing
  std::array<pollfd, 4> polled_{};
};

}  // namespace contourd::ctl
