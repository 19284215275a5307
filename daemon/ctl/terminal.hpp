// The terminal that contourctl runs in: its size, and keys as they are pressed.
#pragma once

#include <termios.h>

#include <optional>
#include <string>
#include <string_view>

namespace contourd::ctl {

// Of standard output's terminal; 80 where it does not say.
[[nodiscard]] int terminal_columns();

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
