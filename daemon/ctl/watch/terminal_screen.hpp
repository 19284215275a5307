// The whole terminal, for a view that is drawn in place: the alternate screen, without echo, until leave() is
// called or the object goes. What was on the terminal is there again then, whatever ended the view. Signals
// that end or stop a program are blocked meanwhile and told as events, so that none ends it in between. A
// terminal that takes nothing is not waited for. Not thread-safe; one at a time.
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

// Whether standard output is a terminal that such a view can be drawn on.
[[nodiscard]] bool has_screen();

class TerminalScreen {
 public:
  TerminalScreen();
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  [[nodiscard]] ScreenSize size() const;

  // Shows these lines, made for size(), and none below them. Where the terminal has not taken what came
  // before, nothing is drawn.
  void draw(const std::vector<ScreenLine>& lines);

  // Waits for the terminal, for `other` to be readable (-1: none) or for so many milliseconds.
  void wait(int other, int milliseconds);
  // What happened meanwhile: handles a change of size, a stop and its end. The signal that ends the view, if
  // one came; SIGINT also for the key q.
  [[nodiscard]] std::optional<int> ended_by();

  // Back to the terminal as it was. Harmless when that was done.
  void leave() noexcept;

 private:
  void enter();
  void stop();
  void read_keys();
  // Without waiting.
  void flush() noexcept;

  FileDescriptor out_;
  FileDescriptor signals_;
  sigset_t before_{};
  std::optional<termios> keyboard_;  // as it was
  bool entered_ = false;
  bool colors_;
  bool keys_end_ = false;  // nothing more comes from the keyboard
  std::optional<int> end_;
  std::string pending_;            // not taken by the terminal yet
  std::vector<ScreenLine> drawn_;  // lines that need not be drawn again
  std::array<pollfd, 4> polled_{};
};

}  // namespace contourd::ctl
