#include "daemon/ctl/watch/watch_command.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/watch/progress_lines.hpp"
#include "daemon/ctl/watch/terminal_screen.hpp"
#include "daemon/ctl/watch/watch_end.hpp"
#include "daemon/ctl/watch/watch_screen.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

int print_end(const Json& ended, bool json) {
  const std::string outcome = ended.value("outcome", ""), reason = ended.value("reason", "");
  if (!json) {
    fmt::print("{}: {}{}\n", printable(ended.value("job", "")), printable(outcome),
               reason.empty() ? "" : ": " + printable_lines(reason));
  }
  return outcome == "done" ? kOk : kFailed;
}

void print_line(const Json& message) {
  fmt::print("{}\n", message.dump(-1, ' ', true));
  std::fflush(stdout);
}

int watch_by_screen(const ClientOptions& options, WatchEnd& end) {
  const WatchResult result = watch_on_screen(options, end);
  const std::string job = printable(result.ended.value("job", ""));
  for (const std::string& warning : result.warnings)
    fmt::print("{}: warning: {}\n", job, printable(warning));
  return print_end(result.ended, false);
}

int watch_by_line(const ClientOptions& options, WatchEnd& end) {
  DaemonConnection connection(options.socket);
  end.begin(connection);
  ProgressLines lines;
  auto ask_at = std::chrono::steady_clock::now() + WatchEnd::kAskInterval;
  while (true) {
    const std::optional<Json> message = connection.receive_until(ask_at);
    if (message) {
      if (options.json && !WatchEnd::is_repeated(*message)) print_line(*message);
      const std::optional<Json> ended = end.take(*message);
      const Json* const status = WatchEnd::status_in(*message);
      if (status != nullptr && !ended && !options.json && end.is_known())
        lines.show(*status, end.job(), end.is_under_way());
      if (ended) return print_end(*ended, options.json);
    }
    if (std::chrono::steady_clock::now() < ask_at) continue;
    ask_at = std::chrono::steady_clock::now() + WatchEnd::kAskInterval;
    end.ask_again(connection);
  }
}

}  // namespace

int watch(const ClientOptions& options, const std::optional<std::string>& job) {
  WatchEnd end(job);
  try {
    return !options.json && has_screen() ? watch_by_screen(options, end) : watch_by_line(options, end);
  } catch (const WatchEnd::NoSuchJob& error) {
    fmt::print(stderr, "contourctl: {}\n", error.sentence);
    return kFailed;
  }
}

void add_watch(Command& program) {
  Command& command = program.add("watch", "Follow the print until it ends");
  auto& job = command.arguments<std::optional<std::string>>();
  command.option("--job", job, "Follow until this job has ended").suggests(current_jobs);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &job] { return watch(client, job); };
}

}  // namespace contourd::ctl
