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

// Whether it ends by then. What nobody asked for is nothing.
bool ends_within(DaemonConnection& connection, Clock::duration time) {
  try {
    (void)connection.receive_until(Clock::now() + time);
    return false;
  } catch (const DaemonError&) {
    return true;
  }
}

}  // namespace

bool SetupDaemon::start_anew(const std::filesystem::path& config, const std::string& name) {
  const bool by_systemd = config == kDefaultConfig;
  const std::string prompt =
      by_systemd
          ? "Enter: systemctl reload-or-restart contourd; skip: no checks:"
          : fmt::format("Enter, when contourd has been started anew with --config {}; skip: no checks:",
                        config.string());
  dialog_.say("contourd must run with what is written now.");
  while (true) {
    std::optional<DaemonConnection> before = connect();
    if (dialog_.ask_for_word(prompt, {"done", "skip"}) == "skip") return false;
    if (by_systemd && !restart_service()) continue;
    if (before &&
        !ends_within(*before, by_systemd ? Clock::duration(kLongestRestart) : kDaemonPollInterval)) {
      dialog_.say("contourd runs on as it was: it restarts once nothing prints.");
      continue;
    }
    if (answers_as(name)) return true;
  }
}

bool SetupDaemon::restart_service() {
  constexpr std::size_t kMostBytes = 1000;
  try {
    if (run_program({"systemctl", "reload-or-restart", "contourd"}, kMostBytes).code == 0) return true;
    dialog_.say("systemctl could not; systemctl status contourd says why.");
  } catch (const std::system_error& error) {
    dialog_.say(fmt::format("{}.", error.what()));
  }
  return false;
}

bool SetupDaemon::answers_as(const std::string& name) {
  std::string why;
  for (const auto end = Clock::now() + kLongestRestart; Clock::now() < end;) {
    try {
      const std::string its = ask("status").value("printer", "");
      if (its == name) return true;
      dialog_.say(fmt::format("contourd runs as {}, not as {}.", its, name));
      return false;
    } catch (const DaemonError& error) {  // it may be starting
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

void SetupDaemon::control(const char* method, const Json& parameters, const char* otherwise) const {
  if (control_by_hand(client_, {method, parameters}, WaitFor::Operation) != kOk) throw DaemonError(otherwise);
}

void SetupDaemon::light(const char* pattern, double seconds) const {
  DaemonConnection picture(client_.socket, kLongestAnswer);  // what it shows goes with it
  picture.send("show", 1, {{"pattern", pattern}});
  const Json reply = picture.receive();
  if (reply.contains("error")) throw DaemonError(reply["error"].value("message", ""));
  control("light_on", {{"seconds", seconds}, {"in_resin", true}}, "There was no light");
}

SetupDaemon::Json SetupDaemon::limit_switch() const {
  const Json inputs = ask("inputs").value("inputs", Json::array());
  for (const Json& input : inputs)
    if (input.value("name", "") == "limit switch" && input.contains("active") && input["active"].is_boolean())
      return input;
  throw DaemonError("contourd cannot read the limit switch: contourctl status says why");
}

std::optional<double> SetupDaemon::height_mm() const {
  return by_hand("height_mm");
}

std::optional<double> SetupDaemon::homing_shift_um() const {
  return by_hand("homing_shift_um");
}

std::optional<double> SetupDaemon::by_hand(const char* field) const {
  const Json number = ask("status")["manual"].value(field, Json());
  return number.is_number() ? std::optional(number.get<double>()) : std::nullopt;
}

}  // namespace contourd::ctl
