// The terminal in which contourctl runs: its properties, its size, and signals while its modes are changed.
#pragma once

#include <csignal>
#include <string_view>

#include "hw/file_descriptor.hpp"

namespace contourd::ctl {

// Returns the width of standard output's terminal, or 80 if it is unknown.
[[nodiscard]] int terminal_columns();

// Prints the label and the text as a line. On a terminal, a wider line is wrapped between words; the next
// lines are indented as the text, or by two columns if the label is wider than a third of the terminal.
void print_wrapped(std::string_view label, std::string_view text);

// True if standard output is a terminal that supports control sequences, according to TERM.
[[nodiscard]] bool knows_sequences();
// True unless NO_COLOR is set and not empty.
[[nodiscard]] bool wants_colors();
// True if this process is in the foreground of its terminal, or standard output is not a terminal.
[[nodiscard]] bool in_foreground();

// Opens standard output again, with its own file description, so that O_NONBLOCK does not affect other users
// of it. Invalid if it cannot be opened.
[[nodiscard]] FileDescriptor open_output_without_waiting();

// Returns the signals that end or stop a program, without ignored ones (nohup ignores SIGHUP).
[[nodiscard]] sigset_t ending_signals();

// Blocks ending_signals() during its lifetime, so that output to the terminal can be completed first; the
// destructor delivers pending signals, and returns after a stopped program continues. SIGTTOU is blocked,
// too, so that the terminal can be set from the background. At most one object at a time. Throws
// std::system_error.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  // For poll(2): readable once a signal is pending.
  [[nodiscard]] int descriptor() const { return waiting_.get(); }

 private:
  FileDescriptor waiting_;
  sigset_t before_{};
};

}  // namespace contourd::ctl
