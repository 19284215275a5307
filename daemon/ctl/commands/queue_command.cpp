#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

std::string size_of(const Json& job) {
  const auto bytes = job["bytes"].get<std::uint64_t>();
  return bytes < 1'000'000 ? fmt::format("{:.1f} kB", static_cast<double>(bytes) / 1e3)
                           : fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string layers_of(const Json& job) {
  const auto thinnest = job["thinnest_layer_um"].get<double>(),
             thickest = job["thickest_layer_um"].get<double>();
  const std::string thickness =
      thinnest == thickest ? fmt::format("{:g}", thinnest) : fmt::format("{:g} to {:g}", thinnest, thickest);
  return fmt::format("{} of {} um", job["layers"].get<std::int64_t>(), thickness);
}

// Returns "exposure_ms 4000 instead of 3000, ...", or an empty text if the ticket overrides no setting of the
// profile.
std::string overrides_of(const Json& job) {
  std::string text;
  for (const Json& each : job.value("overrides", Json::array()))
    text += fmt::format("{}{} {} instead of {}", text.empty() ? "" : ", ", text_of(each, "setting"),
                        each["asked"].get<double>(), each["profile"].get<double>());
  return text;
}

// Returns the job's state in words.
std::string_view state_of(const Json& job) {
  const std::string state = job.value("state", "");
  if (state == "unchecked") return "not checked yet";
  if (state == "checking") return "is being checked";
  if (state == "postponed") return "is checked later";
  if (state == "leaving") return "on its way to failed";
  if (state == "analyzing") return "is being analyzed";
  if (state == "unaccepted") return "waits to be accepted";
  return "ready";
}

void print_job(const Json& job) {
  print_wrapped(fmt::format("{:>3}  ", job.value("number", 0)), text_of(job, "file"));
  std::string state(state_of(job));
  if (job["layers"].is_number()) {
    const auto parts = job["parts"].get<std::int64_t>();
    state += fmt::format(", {}, {}layers {}, {}, {}", readable_seconds(job["print_time_s"].get<double>()),
                         parts > 1 ? fmt::format("{} parts, ", parts) : "", layers_of(job),
                         text_of(job, "resin"), size_of(job));
  }
  print_wrapped("     ", state);
  if (const std::string set = overrides_of(job); !set.empty()) print_wrapped("     by its ticket: ", set);
  if (const std::string why = text_of(job, "waiting_for"); !why.empty()) print_wrapped("     waits: ", why);
}

void print_queue(const Json& waiting) {
  const Json& queue = waiting["queue"];
  const Json& jobs = waiting["jobs"];
  if (queue.empty()) fmt::print("the queue is empty\n");
  for (const Json& job : jobs)
    print_job(job);
  for (std::size_t i = jobs.size(); i < queue.size(); ++i)
    fmt::print("{:>3}  {}\n", i + 1, printable(queue[i].get<std::string>()));
  if (const auto more = waiting.value("more", std::size_t{0}); more > 0) fmt::print("and {} more\n", more);
  for (const Json& file : waiting["arriving"])
    fmt::print("  -  {}\n     still arriving\n", printable(file.get<std::string>()));
}

void print_waiting_job(const Json& waiting) {
  const Json& job = waiting["jobs"][0];
  const auto number = job["number"].get<std::size_t>();
  fmt::print("job       {}\nfile      {}\n", text_of(job, "job"), text_of(job, "file"));
  fmt::print("number    {} of {}\nstate     {}\n", number,
             waiting["queue"].size() + waiting.value("more", std::size_t{0}), state_of(job));
  if (const std::string why = text_of(job, "waiting_for"); !why.empty()) fmt::print("waits     {}\n", why);
  if (!job["layers"].is_number()) return;
  fmt::print("size      {}\nresin     {}\nparts     {}\nlayers    {}, {:.2f} mm high\ntime      {}\n",
             size_of(job), text_of(job, "resin"), job["parts"].get<std::int64_t>(), layers_of(job),
             job["height_mm"].get<double>(), readable_seconds(job["print_time_s"].get<double>()));
  if (const std::string set = overrides_of(job); !set.empty()) fmt::print("ticket    {}\n", set);
  if (const Json& supports = job["supports"]; supports.is_object())
    fmt::print("supports  {}\n", supports_line(supports_in_summary(supports)));
  if (job["resin_ml"].is_number())
    fmt::print("needs     {:.2f} ml of resin\n", job["resin_ml"].get<double>());
  for (const Json& warning : job["warnings"])
    fmt::print("warning   {}\n", printable(warning.get<std::string>()));
}

// Calls the method for the job. Prints the sentence about the job if it succeeds.
int change_job(const ClientOptions& options, const char* method, const std::string& job,
               const char* sentence) {
  const int result = request(options, {method, {{"job", job}}}, [](const Json&) {});
  if (result == kOk && !options.json) fmt::print("{}: {}\n", printable(job), sentence);
  return result;
}

struct QueueArgs {
  std::string job;
  std::optional<int> to;  // place, from 1
  bool first = false, last = false;
};

Json place_in_queue(const QueueArgs& args) {
  if (args.last) return "last";
  return args.to.value_or(1);
}

// Adds a command about one job. Returns its arguments.
QueueArgs& add_job_command(Command& parent, ClientOptions& options, const char* name, const char* help,
                           int (*call)(const ClientOptions& client, const QueueArgs& args)) {
  Command& command = parent.add(name, help);
  auto& args = command.arguments<QueueArgs>();
  command.option("JOB", args.job, kJobHelp).required().suggests(waiting_jobs);
  add_client_options(command, options);
  command.run = [&options, &args, call] { return call(options, args); };
  return args;
}

}  // namespace

void add_queue(Command& program) {
  Command& queue = program.add("queue", "List the waiting jobs, or show, remove or move one");
  // `queue --json show JOB` is valid, too.
  ClientOptions& client = add_client_options(queue);
  queue.run = [&client] { return request(client, {"queue"}, print_queue); };

  add_job_command(queue, client, "show", "Show the details of a waiting job",
                  [](const ClientOptions& options, const QueueArgs& args) {
                    return request(options, {"queue", {{"job", args.job}}}, print_waiting_job);
                  });
  add_job_command(queue, client, "remove", "Remove a job from the queue; its files go to failed",
                  [](const ClientOptions& options, const QueueArgs& args) {
                    return change_job(options, "queue_remove", args.job,
                                      "removed; its files go to failed, with the reason beside them");
                  });
  QueueArgs& args = add_job_command(
      queue, client, "move", "Move a job within the queue",
      [](const ClientOptions& options, const QueueArgs& moved) {
        return request(options, {"queue_move", {{"job", moved.job}, {"to", place_in_queue(moved)}}},
                       print_queue);
      });
  Command& move = queue.commands.back();
  move.option("--to", args.to, "Move to this place, counted from 1").from_to(1, 1000).in_group("Place");
  move.option("--first", args.first, "Move to the start of the queue").in_group("Place");
  move.option("--last", args.last, "Move to the end of the queue").in_group("Place");

  add_job_command(
      program, program.arguments<ClientOptions>(), "accept", "Accept a job that is waiting for confirmation",
      [](const ClientOptions& options, const QueueArgs& accepted) {
        return change_job(options, "accept", accepted.job, "accepted; it is printed when its turn comes");
      });
  program.commands.back().options.front().suggests(unaccepted_jobs);
}

void add_status(Command& program) {
  add_request(program, "status", "Show the current activity of the printer", "status");
}

}  // namespace contourd::ctl
