// The terminal that contourctl runs in: what it is, its size, keys as they are pressed, and signals while it
// is not as its user left it.
#pragma once

#include <termios.h>

#include <csignal>
#include <optional>
#include <string>
#include <string_view>

#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

// Of standard output's terminal; 80 where it does not say.
[[nodiscard]] int terminal_columns();

// Prints the label and the text as a line. On a terminal, what is wider than it is broken between words; it
// goes on under the text where that has most of the room, else two columns from the left.
void print_wrapped(std::string_view label, std::string_view text);

// Whether standard output is a terminal that knows control sequences, by TERM.
[[nodiscard]] bool knows_sequences();
// Whether the user wants colours, by NO_COLOR.
[[nodiscard]] bool wants_colors();
// Whether the terminal of standard output, if it is one, is this program's at the moment.
[[nodiscard]] bool in_foreground();

// Standard output once more, by a description of its own: writes to it do not wait, anybody else's do as
// ever. Not valid where that cannot be had.
[[nodiscard]] FileDescriptor open_output_without_waiting();

// Signals that end or stop a program. One that is ignored, as nohup does with SIGHUP, is not among them.
[[nodiscard]] sigset_t ending_signals();

// While it lives, these signals wait, so that what has been begun on the terminal can be ended first. When it
// goes, they do what they do; one that stops the program comes back from there. From the background, the
// terminal can be set meanwhile. One at a time. Throws std::system_error.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  // Readable, for poll(2), once one waits.
  [[nodiscard]] int descriptor() const { return waiting_.get(); }

 private:
  FileDescriptor waiting_;
  sigset_t before_{};
};

// A key: a character, or an arrow.
enum class Arrow { Up, Down };
struct Key {
  char character = 0;  // 0: an arrow, or a key that has no meaning here
  std::optional<Arrow> arrow;
};

// Takes the first key from what a terminal sent. Nothing when there is none.
[[nodiscard]] std::optional<Key> take_key(std::string_view& sent);

// While it lives, standard input gives each key at once, without echo, Ctrl-C as a character too. SIGTERM,
// SIGHUP and SIGINT set ended() instead of ending the program, so that the terminal is left as it was. One at
// a time. Throws UsageError where standard input and output are no terminal; `what` begins its sentence.
class KeyInput {
 public:
  explicit KeyInput(std::string_view what);
  ~KeyInput();
  KeyInput(const KeyInput&) = delete;
  KeyInput& operator=(const KeyInput&) = delete;

  // Waits for keys or until `other` is readable. What was typed; empty when it was not keys.
  [[nodiscard]] std::string wait(int other);
  // The terminal is gone, or a signal came.
  [[nodiscard]] bool ended() const;

 private:
  termios before_{};
  bool closed_ = false;
};

}  // namespace contourd::ctl
