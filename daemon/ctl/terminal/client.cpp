#include "daemon/ctl/terminal/client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

constexpr const char* kSocketHelp = "Control socket of contourd (environment: CONTOURD_SOCKET)";

void print_analysis(const Json& analysis) {
  fmt::print("resin     {:.2f} ml\n", analysis.value("resin_ml", 0.0));
  for (const Json& warning : analysis["warnings"])
    print_wrapped("warning   ", printable(warning.get<std::string>()));
}

}  // namespace

std::filesystem::path default_socket() {
  const char* const socket = std::getenv("CONTOURD_SOCKET");
  return socket != nullptr ? socket : kDefaultSocket;
}

ClientOptions& add_socket_option(Command& command) {
  auto& client = command.arguments<ClientOptions>();
  command.option("--socket", client.socket, kSocketHelp);
  return client;
}

ClientOptions& add_client_options(Command& command) {
  auto& client = command.arguments<ClientOptions>();
  add_client_options(command, client);
  return client;
}

void add_client_options(Command& command, ClientOptions& of_group) {
  command.option("--socket", of_group.socket, kSocketHelp);
  command.option("--json", of_group.json, "Print JSON, one message per line");
}

void add_request(Command& parent, const char* name, const char* help, const char* method,
                 void (*print)(const Json& result)) {
  Command& command = parent.add(name, help);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, method, print] { return request(client, {method}, print); };
}

void print_status(const Json& status) {
  const auto line = [](std::string_view label, const std::string& text) {
    if (!text.empty()) print_wrapped(label, text);
  };
  line("printer   ", text_of(status, "printer"));
  fmt::print("state     {}\n", text_of(status, "state"));
  if (const Json& job = status["job"]; job.is_object()) {
    line("job       ", text_of(job, "name"));
    if (job.contains("layer")) {
      std::string pause = text_of(job, "pause");
      if (pause.empty()) pause = text_of(job, "planned_pause");
      line("layer     ",
           fmt::format("{} of {}, {:.3f} mm, {} left{}", job.value("layer", 0), job.value("layers", 0),
                       job.value("height_mm", 0.0), readable_seconds(job.value("time_left_s", 0.0)),
                       pause.empty() ? "" : ", pause " + pause));
      for (const Json& copy : job.value("excluded", Json::array()))
        line("excluded  ", printable(copy.get<std::string>()));
      line("stopped   ", text_of(job, "interruption"));
      for (const Json& warning : job.value("warnings", Json::array()))
        line("warning   ", printable(warning.get<std::string>()));
      if (const auto more = job.value("warnings_more", std::size_t{0}); more > 0)
        fmt::print("warning   {} more: see the log\n", more);
    }
    const Json supports = job.value("supports", Json());
    if (const auto carriers = supports.is_object() ? supports.value("carriers", 0U) : 0; carriers > 0)
      line("supports  ",
           count_of(carriers, "model carries its own in its file", "models carry their own in their files"));
    if (job.contains("analysis") && job["analysis"].is_object()) print_analysis(job["analysis"]);
  }
  const std::string occupant = text_of(status, "plate_job");
  line("plate     ", text_of(status, "plate") + (occupant.empty() ? "" : " by " + occupant));
  fmt::print("queue     {}\n", status.value("queued", 0));
  for (const auto& [file, why] : status["postponed"].items())
    fmt::print("postponed {}: {}\n", printable(file), why.get<std::string>());
  for (const auto& [file, why] : status["unaccepted"].items())
    fmt::print("accept    {}: {}\n", printable(file), printable(why.get<std::string>()));
  if (const auto more = status.value("unaccepted_more", std::size_t{0}); more > 0)
    fmt::print("accept    {} more in the queue\n", more);
  for (const Json& file : status["deletable"])
    fmt::print("deletable {} in incoming: it is finished, but cannot be moved away\n",
               printable(file.get<std::string>()));
  for (const auto& [file, why] : status["ignored"].items())
    fmt::print("ignored   {} in incoming: {}\n", printable(file), printable(why.get<std::string>()));
  if (const auto more = status.value("ignored_more", std::size_t{0}); more > 0)
    fmt::print("ignored   {} more in incoming\n", more);
  line("machine   ", text_of(status, "not_ready_reason"));
  line("held      ", text_of(status, "held"));
  const Json &waiting_for = status["waiting_for"], &unaccepted = status["unaccepted"];
  if (waiting_for != status["held"] && std::ranges::find(unaccepted, waiting_for) == unaccepted.end())
    line("waiting   ", text_of(status, "waiting_for"));
  for (const Json& reminder : status["reminders"])
    line("reminder  ", printable(reminder.get<std::string>()));
  if (const Json& last = status["last"]; last.is_object()) line("last job  ", end_of(last));
}

void print_json(const Json& message) {
  fmt::print("{}\n", message.dump(-1, ' ', true));
}

int print_refusal(const Json& answer) {
  fmt::print(stderr, "contourctl: {}\n", printable_lines(answer["error"].value("message", "")));
  return kFailed;
}

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? printable(found->get<std::string>()) : "";
}

std::string end_of(const Json& ended) {
  const std::string reason = ended.value("reason", "");
  return fmt::format("{}: {}{}", text_of(ended, "job"), text_of(ended, "outcome"),
                     reason.empty() ? "" : ": " + printable_lines(reason));
}

std::filesystem::path find_spool(const ClientOptions& options,
                                 const std::optional<std::filesystem::path>& given) {
  if (given) return *given;
  DaemonConnection connection(options.socket);
  const std::string spool = connection.ask({"status"}).value("/result/spool"_json_pointer, "");
  if (spool.empty())
    throw DaemonError(
        fmt::format("contourd on {} does not report its spool folder: use --spool", options.socket.string()));
  return spool;
}

std::string readable_seconds(double seconds) {
  return readable(std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds)));
}

int request(const ClientOptions& options, const Request& request, void (*print)(const Json&)) {
  DaemonConnection connection(options.socket);
  const Json answer = connection.ask(request);
  if (options.json) print_json(answer);
  if (answer.contains("error")) return options.json ? kFailed : print_refusal(answer);
  if (!options.json) print(answer["result"]);
  return kOk;
}

}  // namespace contourd::ctl
