#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/program.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct LogsOptions {
  std::optional<std::string> job;  // only lines about this job
  std::optional<int> lines;        // at most; nullopt: all lines of a job, or the latest 100
  bool follow = false;
};

using Words = std::vector<std::string>;

// Default number of lines without a job.
constexpr int kLines = 100;

// Returns the journalctl command that selects the lines, without options for their format.
Words question(const LogsOptions& options) {
  Words words{"journalctl", "--unit=contourd.service"};
  if (!options.job) return words;
  // The name as it is logged. A file name stands for its job, too: journalctl accepts any of a field's
  // values.
  words.push_back("JOB_ID=" + printable(*options.job));
  if (is_model_name(*options.job)) words.push_back("JOB_ID=" + printable(job_name_of(*options.job)));
  return words;
}

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

bool has_lines(const LogsOptions& options) {
  const ProgramOutput one =
      run_program(with(question(options), {"--lines=1", "--quiet", "--no-pager", "--output=cat"}), 1);
  return !one.text.empty();
}

int logs(const LogsOptions& options) {
  try {
    if (!options.follow && !has_lines(options)) {
      const std::string whose = options.job ? "of a job " + in_quotes(*options.job) : "of contourd";
      fmt::print(
          stderr,
          "contourctl: the journal has no lines {} that you may read; only root and the group "
          "systemd-journal can read all lines, and a contourd that was not started by systemd logs to its "
          "standard error\n",
          whose);
      return kFailed;
    }
    Words words = with(question(options), {"--output=short", "--no-hostname"});
    if (options.lines || !options.job)
      words.push_back(fmt::format("--lines={}", options.lines.value_or(kLines)));
    if (options.follow) words.emplace_back("--follow");
    become_program(words);
  } catch (const std::system_error& error) {
    throw DaemonError(fmt::format("cannot read the journal: {}", error.what()));
  }
}

}  // namespace

void add_logs(Command& program) {
  Command& command = program.add("logs", "Show contourd's entries in the journal");
  auto& options = command.arguments<LogsOptions>();
  command.option("JOB", options.job, "Show only entries about this job").suggests(current_jobs);
  command.option("-n,--lines", options.lines, "Show the latest N lines (default without a job: 100)")
      .from_to(1, 1'000'000);
  command.option("-f,--follow", options.follow, "Keep printing new lines");
  command.run = [&options] { return logs(options); };
}

}  // namespace contourd::ctl
