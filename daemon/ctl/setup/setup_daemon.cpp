#include "daemon/ctl/setup/setup_daemon.hpp"

#include <fmt/format.h>

#include <chrono>
#include <system_error>
#include <thread>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/program.hpp"

namespace contourd::ctl {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kDaemonPollInterval = 100ms;
constexpr auto kLongestRestart = 60s;
constexpr auto kLongestAnswer = 5s;

// True if the connection ends within this time. Messages that arrive meanwhile are ignored.
bool ends_within(DaemonConnection& connection, Clock::duration time) {
  try {
    (void)connection.receive_until(Clock::now() + time);
    return false;
  } catch (const DaemonError&) {
    return true;
  }
}

}  // namespace

bool SetupDaemon::restart(const std::filesystem::path& config, const std::string& name) {
  const bool by_systemd = config == kDefaultConfig;
  const std::string prompt =
      by_systemd ? "Enter: systemctl reload-or-restart contourd; skip: no checks:"
                 : fmt::format("Restart contourd with --config {}, then press Enter; skip: no checks:",
                               config.string());
  dialog_.say("contourd must restart with the new configuration.");
  while (true) {
    std::optional<DaemonConnection> before = connect();
    if (dialog_.ask_for_word(prompt, {"done", "skip"}) == "skip") return false;
    if (by_systemd && !restart_service()) continue;
    if (before &&
        !ends_within(*before, by_systemd ? Clock::duration(kLongestRestart) : kDaemonPollInterval)) {
      dialog_.say("contourd has not restarted yet: it restarts as soon as no job is printed.");
      continue;
    }
    if (answers_as(name)) return true;
  }
}

bool SetupDaemon::restart_service() {
  constexpr std::size_t kMostBytes = 1000;
  try {
    if (run_program({"systemctl", "reload-or-restart", "contourd"}, kMostBytes).code == 0) return true;
    dialog_.say("systemctl failed; systemctl status contourd shows why.");
  } catch (const std::system_error& error) {
    dialog_.say(fmt::format("{}.", error.what()));
  }
  return false;
}

bool SetupDaemon::answers_as(const std::string& name) {
  std::string why;
  for (const auto end = Clock::now() + kLongestRestart; Clock::now() < end;) {
    try {
      const std::string printer = ask("status").value("printer", "");
      if (printer == name) return true;
      dialog_.say(fmt::format("contourd runs as {}, not as {}.", printer, name));
      return false;
    } catch (const DaemonError& error) {  // contourd may still be starting
      why = error.what();
    }
    std::this_thread::sleep_for(kDaemonPollInterval);
  }
  dialog_.say(fmt::format("{}.", why));
  return false;
}

std::optional<DaemonConnection> SetupDaemon::connect() const {
  try {
    return DaemonConnection(client_.socket, kLongestAnswer);
  } catch (const DaemonError&) {
    return std::nullopt;
  }
}

SetupDaemon::Json SetupDaemon::ask(const char* method, const Json& parameters) const {
  DaemonConnection connection(client_.socket, kLongestAnswer);
  connection.send(method, 1, parameters);
  const std::optional<Json> reply = connection.receive_until(Clock::now() + kLongestAnswer);
  if (!reply) throw DaemonError(fmt::format("contourd on {} does not answer", client_.socket.string()));
  if (reply->contains("error")) throw DaemonError((*reply)["error"].value("message", ""));
  return reply->value("result", Json::object());
}

void SetupDaemon::control(const char* method, const Json& parameters, const char* failure) const {
  if (control_by_hand(client_, {method, parameters}, WaitFor::Operation) != kOk) throw DaemonError(failure);
}

void SetupDaemon::light(const char* pattern, double seconds) const {
  DaemonConnection picture(client_.socket, kLongestAnswer);  // contourd ends the picture with this connection
  picture.send("show", 1, {{"pattern", pattern}});
  const Json reply = picture.receive();
  if (reply.contains("error")) throw DaemonError(reply["error"].value("message", ""));
  control("light_on", {{"seconds", seconds}, {"in_resin", true}}, "The light did not turn on");
}

SetupDaemon::Json SetupDaemon::limit_switch() const {
  const Json inputs = ask("inputs").value("inputs", Json::array());
  for (const Json& input : inputs)
    if (input.value("name", "") == "limit switch" && input.contains("active") && input["active"].is_boolean())
      return input;
  throw DaemonError("contourd cannot read the limit switch: contourctl status shows why");
}

std::optional<double> SetupDaemon::by_hand(const char* field) const {
  const Json number = ask("status")["manual"].value(field, Json());
  return number.is_number() ? std::optional(number.get<double>()) : std::nullopt;
}

}  // namespace contourd::ctl
