// Dialogs with the user on standard output and input: prompts and answers line by line, or single keys. Not
// thread-safe.
#pragma once

#include <termios.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace contourd::ctl {

// Parses a finite number with a decimal point. Returns nullopt if the word is not exactly one number.
[[nodiscard]] std::optional<double> number_of(const std::string& word);

// Thrown when the user quits, or when standard input ends.
struct DialogLeft {};

// Reads standard input line by line. Lines that are longer than any answer are cut.
class LineInput {
 public:
  // Blocks until there is a line. Returns nullopt at the end of the input.
  [[nodiscard]] std::optional<std::string> line();
  // Waits at most this time. True if line() would not block.
  [[nodiscard]] bool wait(std::chrono::milliseconds time);

 private:
  bool read_more();

  std::string read_;
  bool ended_ = false;
};

class Dialog {
 public:
  // Prints a paragraph, wrapped to the terminal's width (at most 100 columns). Lines after the first are
  // indented by `indent` spaces.
  void say(std::string_view text, std::size_t indent = 0) const;

  // Asks for one line; the prompt is wrapped as say() wraps. After the answer `?`, says the help and asks
  // again. This and the next functions throw DialogLeft on `q` or `quit`, and at the end of the input.
  [[nodiscard]] std::string ask(std::string_view prompt, std::string_view help = "Enter continues; q quits.");
  // Asks until the answer is one of the words or its beginning. An empty line selects the first word.
  [[nodiscard]] std::string ask_for_word(std::string_view prompt, const std::vector<std::string>& words);
  // Asks until the answer is a number within the limits. Returns nullopt for an empty line.
  [[nodiscard]] std::optional<double> ask_for_number(std::string_view prompt, double least, double most);
  // Waits at most this time for a line, and discards it. True if there was one.
  [[nodiscard]] bool typed_within(std::chrono::milliseconds time);

 private:
  LineInput input_;
};

// A key: a character, or an arrow.
enum class Arrow { Up, Down };
struct Key {
  char character = 0;  // 0: an arrow, or a key that has no meaning here
  std::optional<Arrow> arrow;
};

// Removes the first key from the bytes that a terminal sent, and returns it. Returns nullopt if there is
// none.
[[nodiscard]] std::optional<Key> take_key(std::string_view& sent);

// During its lifetime, standard input delivers each key at once, without echo, and Ctrl-C as a character.
// SIGTERM, SIGHUP and SIGINT set ended() instead of ending the program, so that the destructor can restore
// the terminal. At most one object at a time. Throws UsageError if standard input or output is not a
// terminal; `what` begins the message.
class KeyInput {
 public:
  explicit KeyInput(std::string_view what);
  ~KeyInput();
  KeyInput(const KeyInput&) = delete;
  KeyInput& operator=(const KeyInput&) = delete;

  // Waits for keys or until `other` is readable. Returns the typed bytes, possibly none.
  [[nodiscard]] std::string wait(int other);
  // True after a signal, or if the terminal is gone.
  [[nodiscard]] bool ended() const;

 private:
  termios before_{};
  bool closed_ = false;
};

}  // namespace contourd::ctl
