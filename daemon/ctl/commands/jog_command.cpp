#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct JogOptions {
  double light_s = 5;
  bool plate_is_clear = false, in_resin = false;
};

using Json = DaemonConnection::Json;

enum JogQuestion { kJogWatch = 1, kJogStatus, kJogRequest };

constexpr std::string_view kHelp =
    "up, down (or k, j)  move by the step     h  home       m  motor off\n"
    "1 2 3 4 5           step 0.01 to 50 mm   l  light      g  next picture\n"
    "space               stop                 q  quit\n";
// Minimum width for kHelp; a narrower terminal gets kNarrowHelp.
constexpr int kHelpColumns = 71;
constexpr std::string_view kNarrowHelp =
    "up, down, k, j  move by the step\n"
    "1 to 5          step 0.01 to 50 mm\n"
    "space stop      h home     m motor off\n"
    "g next picture  l light    q quit\n";

constexpr std::array kSteps_mm{0.01, 0.1, 1.0, 10.0, 50.0};
constexpr std::array<const char*, 5> kPictures{"grid", "border", "focus", "dimensions", "black"};
constexpr char kCtrlC = 3, kCtrlD = 4;

// Translates keys into requests to the daemon, and shows the daemon's answers in a status line.
class Jog {
 public:
  Jog(DaemonConnection& connection, const JogOptions& options) : connection_(connection), options_(options) {}

  // Handles a key. Returns false if the user wants to quit.
  [[nodiscard]] bool take(const Key& key) {
    if (asks_for_light_) {
      asks_for_light_ = false;
      if (key.character == 'y') light();
      draw();
      return true;
    }
    if (key.character == 'q' || key.character == kCtrlC || key.character == kCtrlD) return false;
    if (key.character == ' ') {
      send("stop");
    } else if (key.character >= '1' && key.character < '1' + static_cast<char>(kSteps_mm.size())) {
      step_mm_ = kSteps_mm[static_cast<std::size_t>(key.character - '1')];
    } else if (is_idle()) {
      begin(key);
    }
    draw();
    return true;
  }

  // Handles a message of the daemon.
  void take(const Json& message) {
    if (message.contains("error")) {
      print_sentence(message["error"].value("message", ""));
      asked_ = false;
      draw();
      return;
    }
    const Json& status = message.contains("params") ? message["params"] : message["result"];
    if (message.value("id", 0) == kJogRequest) asked_ = false;
    if (!status.is_object() || !status.contains("manual")) return;
    const Json problem = status["manual"]["problem"];
    if (problem.is_string() && problem != manual_.value("problem", Json()))
      print_sentence(problem.get<std::string>());
    manual_ = status["manual"];
    prints_ = status.contains("job") && status["job"].is_object();
    draw();
  }

  // Draws the status line.
  void draw() {
    std::string line;
    if (asks_for_light_) {
      line = fmt::format("UV light for {:g} s. Eyes protected, no one near the vat? y/n", options_.light_s);
    } else if (manual_.is_object()) {
      const Json &height = manual_["height_mm"], &picture = manual_["picture"];
      line = fmt::format("{}   step {:g} mm   {}{}",
                         height.is_number() ? fmt::format("height {:.3f} mm", height.get<double>())
                                            : std::string("height unknown (h)"),
                         step_mm_, asked_ ? "..." : state(),
                         picture.is_string() ? "   shows " + printable(picture.get<std::string>()) : "");
    }
    if (in_place_) {
      fmt::print("\r\x1b[K{:.{}}", line, terminal_columns() - 1);
    } else if (line != shown_) {
      fmt::print("{}\n", line);
    }
    shown_ = line;
    std::fflush(stdout);
  }

 private:
  // Prints a sentence above the status line.
  void print_sentence(const std::string& sentence) const {
    fmt::print("{}{}\n", in_place_ ? "\r\x1b[K" : "", printable_lines(sentence));
  }
  // During a print, the manual state is "idle" although the printer is busy.
  [[nodiscard]] std::string state() const {
    return prints_ ? "printing" : printable(manual_.value("state", ""));
  }
  // True if a key starts an operation. A key that is pressed during an operation is ignored.
  [[nodiscard]] bool is_idle() const {
    return !asked_ && manual_.is_object() && manual_.value("state", "") == "idle";
  }

  void begin(const Key& key) {
    if (key.arrow == Arrow::Up || key.character == 'k') return move(step_mm_);
    if (key.arrow == Arrow::Down || key.character == 'j') return move(-step_mm_);
    switch (key.character) {
      case 'h':
        return send("home", motion());
      case 'm':
        return send("motor_off");
      case 'g':
        return send("show", {{"pattern", kPictures[next_picture_++ % kPictures.size()]}});
      case 'l':
        asks_for_light_ = true;
        return;
      default:
        return;
    }
  }
  [[nodiscard]] Json motion() const {
    return options_.plate_is_clear ? Json{{"plate_is_clear", true}} : Json::object();
  }
  void move(double by_mm) {
    Json parameters = motion();
    parameters["by_mm"] = by_mm;
    send("move", parameters);
  }
  void light() {
    Json parameters{{"seconds", options_.light_s}};
    if (options_.in_resin) parameters["in_resin"] = true;
    send("light_on", parameters);
  }
  void send(const char* method, const Json& parameters = Json::object()) {
    connection_.send(method, kJogRequest, parameters);
    asked_ = true;
  }

  DaemonConnection& connection_;
  JogOptions options_;
  double step_mm_ = 1;
  std::size_t next_picture_ = 0;
  bool asked_ = false, asks_for_light_ = false, prints_ = false;
  Json manual_;
  bool in_place_ = knows_sequences();  // redraw one line; otherwise print a line for each change
  std::string shown_;
};

// Ends the status line when jog() returns or throws.
struct LineEnd {
  LineEnd() = default;
  LineEnd(const LineEnd&) = delete;
  LineEnd& operator=(const LineEnd&) = delete;
  ~LineEnd() {
    std::putchar('\n');
    std::fflush(stdout);
  }
};

int jog(const ClientOptions& client, const JogOptions& options) {
  KeyInput keys("jog");
  DaemonConnection connection(client.socket);
  connection.send("watch", kJogWatch);
  connection.send("status", kJogStatus);
  Jog state(connection, options);
  fmt::print("{}", terminal_columns() < kHelpColumns ? kNarrowHelp : kHelp);
  const LineEnd line_end;
  while (!keys.ended()) {
    const std::string typed = keys.wait(connection.descriptor());
    std::string_view left = typed;
    while (const std::optional<Key> key = take_key(left)) {
      if (!state.take(*key)) return kOk;
    }
    while (const std::optional<Json> message = connection.receive_until(std::chrono::steady_clock::now()))
      state.take(*message);
  }
  return kOk;
}

}  // namespace

void add_jog(Command& program) {
  Command& command = program.add("jog", "Move the plate by keys");
  auto& options = command.arguments<JogOptions>();
  command.option("--light-seconds", options.light_s, "Duration of the light that key l turns on, s");
  command.option("--plate-is-clear", options.plate_is_clear, kPlateIsClearHelp);
  command.option("--in-resin", options.in_resin, "Allow light while the plate may be in the resin");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &options] { return jog(client, options); };
}

}  // namespace contourd::ctl
