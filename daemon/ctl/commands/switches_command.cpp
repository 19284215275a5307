#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

// The daemon counts edges, so no edge is missed between two requests.
constexpr auto kAskInterval = std::chrono::milliseconds(100);

std::string switch_state(const Json& input) {
  const Json& active = input["active"];
  if (!active.is_boolean()) return "cannot be read";
  const std::string name = input.value("name", "");
  if (name == "emergency stop") return active.get<bool>() ? "pressed" : "released";
  if (name == "power fail") return active.get<bool>() ? "failing" : "good";
  if (name == "force") return active.get<bool>() ? "active" : "inactive";
  if (name == "lid") return active.get<bool>() ? "open" : "closed";
  if (name.starts_with("encoder")) return active.get<bool>() ? "high" : "low";
  return active.get<bool>() ? "reached" : "not reached";
}

std::string line_of(const Json& input) {
  return fmt::format("{:<15} {:<14} {:>6} edges  {}", printable(input.value("name", "")), switch_state(input),
                     input.value("edges", std::uint64_t{0}), printable(input.value("line", "")));
}

class SwitchView {
 public:
  explicit SwitchView(bool json) : json_(json), in_place_(!json && knows_sequences()) {}

  void show(const Json& inputs) {
    if (inputs == shown_) return;
    if (json_)
      print_json(inputs);
    else if (in_place_)
      redraw(inputs);
    else
      print_changed(inputs);
    shown_ = inputs;
    std::fflush(stdout);
  }

 private:
  // Redraws the lines in place. After a change of the terminal's width, the position of the old lines is
  // unknown: they stay, and new lines follow.
  void redraw(const Json& inputs) {
    const int columns = std::exchange(columns_, terminal_columns());
    if (columns == columns_ && shown_.is_array() && !shown_.empty()) fmt::print("\x1b[{}A", shown_.size());
    for (const Json& input : inputs)
      fmt::print("\r\x1b[K{:.{}}\n", line_of(input), columns_);
  }
  void print_changed(const Json& inputs) const {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (!shown_.is_array() || i >= shown_.size() || shown_[i] != inputs[i])
        fmt::print("{}\n", line_of(inputs[i]));
    }
  }

  bool json_, in_place_;
  int columns_ = 0;  // width of the terminal when the lines were drawn
  Json shown_;
};

int show_switches(const ClientOptions& options, bool once) {
  DaemonConnection connection(options.socket);
  SwitchView view(options.json);
  for (auto next = std::chrono::steady_clock::now();; next += kAskInterval) {
    const Json reply = connection.ask({"inputs"});
    if (reply.contains("error")) return print_refusal(reply);
    const Json& inputs = reply["result"]["inputs"];
    if (inputs.empty() && !options.json) {
      fmt::print(stderr, "contourctl: no input line is open; contourctl status says why\n");
      return kFailed;
    }
    view.show(inputs);
    if (once) return kOk;
    // The daemon sends nothing unasked: this waits, and throws if the daemon is gone.
    (void)connection.receive_until(next + kAskInterval);
  }
}

}  // namespace

void add_switches(Command& program) {
  Command& command = program.add("switches", "Show the states of switches and other inputs, live");
  auto& once = command.arguments<bool>();
  command.option("--once", once, "Print the states once");
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &once] { return show_switches(client, once); };
}

}  // namespace contourd::ctl
