#include "daemon/ctl/commands/commands.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct HistoryOptions {
  int last = 20;
  std::string since, outcome, resin, job;
  bool csv = false;
};

// Upper limit of HistoryOptions::last.
constexpr int kLongestHistory = 10'000;

using Json = DaemonConnection::Json;
using std::chrono::system_clock;

// The daemon returns at most this many jobs per request.
constexpr int kLongestPage = 100;
// The year 2200, which std::chrono::system_clock can still represent.
constexpr std::time_t kLatest = 7'258'118'400;

// Parses "30d", "12h", or a date in the local time zone.
system_clock::time_point parse_since(const std::string& word) {
  int number = 0, used = 0;
  char unit = ' ';
  const auto whole = [&](int parts, int wanted) {
    return parts == wanted && static_cast<std::size_t>(used) == word.size();
  };
  if (whole(std::sscanf(word.c_str(), "%6d%c%n", &number, &unit, &used), 2) && (unit == 'd' || unit == 'h') &&
      number >= 0 && number <= 9999)
    return system_clock::now() - std::chrono::hours((unit == 'd' ? 24 : 1) * number);
  std::tm date{};
  const char* const end = ::strptime(word.c_str(), "%Y-%m-%d", &date);
  // Checked here because mktime() accepts February 31 and returns a day of March.
  const bool is_day = std::chrono::year_month_day(std::chrono::year(date.tm_year + 1900),
                                                  std::chrono::month(static_cast<unsigned>(date.tm_mon + 1)),
                                                  std::chrono::day(static_cast<unsigned>(date.tm_mday)))
                          .ok();
  date.tm_isdst = -1;
  const std::time_t time = std::mktime(&date);
  if (end == nullptr || end != word.c_str() + word.size() || !is_day || time < 0 || time > kLatest)
    throw UsageError(fmt::format("--since {}: expected a date such as 2026-11-20, or 7d, or 12h", word));
  return system_clock::from_time_t(time);
}

Json parameters_of(const HistoryOptions& options) {
  Json parameters = Json::object();
  const auto set = [&parameters](const char* name, const std::string& word) {
    if (!word.empty()) parameters[name] = word;
  };
  set("outcome", options.outcome);
  set("resin", options.resin);
  set("job", options.job);
  if (!options.since.empty()) parameters["since"] = iso_time(parse_since(options.since));
  return parameters;
}

// Requests pages until there are enough jobs. Returns one answer with the jobs of all pages, or the daemon's
// error.
Json ask(DaemonConnection& connection, const HistoryOptions& options) {
  Json parameters = parameters_of(options);
  std::vector<Json> jobs;  // the latest first
  Json answer;
  for (int left = options.last; left > 0; left = options.last - static_cast<int>(jobs.size())) {
    parameters["last"] = std::min(left, kLongestPage);
    answer = connection.ask({"history", parameters});
    if (answer.contains("error")) return answer;
    Json& page = answer["result"]["ended"];
    jobs.insert(jobs.end(), page.rbegin(), page.rend());
    const Json& before = answer["result"]["before"];
    if (before.is_null() || page.empty()) break;
    parameters["before"] = before;
  }
  Json all = Json::array();
  std::ranges::move(jobs.rbegin(), jobs.rend(), std::back_inserter(all.get_ref<Json::array_t&>()));
  answer["result"]["ended"] = std::move(all);
  return answer;
}

// Converts a time of the daemon's answer to local time. Returns the text unchanged if it is not a time.
std::string local_time(const std::string& text) {
  std::tm utc{};
  if (::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &utc) == nullptr) return printable(text);
  const std::time_t time = ::timegm(&utc);
  std::tm local{};
  ::localtime_r(&time, &local);
  return fmt::format("{:%Y-%m-%d %H:%M}", local);
}

// Returns "800 of 800 layers, 3 h 05 min, 12.34 ml of standard", or an empty text for a job that was not
// printed.
std::string figures_of(const Json& job) {
  if (job.value("resin", "").empty()) return "";
  return fmt::format("{} of {} layers, {}, {:.2f} ml of {}", job.value("layers_exposed", 0),
                     job.value("layers", 0), readable_seconds(job.value("print_time_s", 0.0)),
                     job.value("resin_ml", 0.0), printable(job.value("resin", "")));
}

void print_lines(const Json& jobs) {
  if (jobs.empty()) fmt::print("no job has ended\n");
  for (const Json& job : jobs) {
    const std::string reason = job.value("reason", ""), figures = figures_of(job);
    print_wrapped(
        local_time(job.value("ended", "")) + "  ",
        fmt::format("{}: {}{}{}", printable(job.value("job", "")), printable(job.value("outcome", "")),
                    reason.empty() ? "" : ": " + printable(reason),
                    figures.empty() ? "" : fmt::format(" ({})", figures)));
  }
}

// Returns a quoted cell (RFC 4180). An apostrophe keeps a spreadsheet from running a text as a formula.
std::string csv_text(const std::string& text) {
  std::string cell = printable(text);
  if (!cell.empty() && std::string_view("=+-@").find(cell.front()) != std::string_view::npos)
    cell.insert(0, 1, '\'');
  for (std::size_t at = cell.find('"'); at != std::string::npos; at = cell.find('"', at + 2))
    cell.insert(at, 1, '"');
  return '"' + cell + '"';
}

std::string csv_cell(const Json& value) {
  if (value.is_number()) return value.dump();
  if (value.is_string()) return csv_text(value.get<std::string>());
  std::string list;
  for (const Json& each : value)
    if (each.is_string()) list += (list.empty() ? "" : "; ") + each.get<std::string>();
  return csv_text(list);
}

void print_csv(const Json& jobs) {
  constexpr std::array<const char*, 19> kColumns{"job",      "outcome",        "reason",
                                                 "began",    "ended",          "resin",
                                                 "settings", "height_mm",      "layer_height_um",
                                                 "layers",   "layers_exposed", "print_time_s",
                                                 "lit_s",    "light_asked_s",  "most_light_over_ms",
                                                 "resin_ml", "interruptions",  "late_steps",
                                                 "warnings"};
  fmt::print("{}\n", fmt::join(kColumns, ","));
  for (const Json& job : jobs) {
    std::string line;
    for (const char* column : kColumns)
      line += (line.empty() ? "" : ",") + csv_cell(job.contains(column) ? job[column] : Json(""));
    fmt::print("{}\n", line);
  }
}

// Returns " of 300" for a limit of 300, or an empty text if there is no limit.
std::string limit_of(const Json& part, const char* key) {
  return part[key].is_number() ? fmt::format(" of {:.10g}", part[key].get<double>()) : "";
}

// Prints the part's use since it was new.
void print_part(const Json& part) {
  const std::string since = part["replaced"].is_string()
                                ? "since " + local_time(part["replaced"].get<std::string>())
                                : "since the history began";
  const auto used = [&part](const char* key, const char* limit, const char* one) {
    const auto number = part.value(key, std::uint64_t{0});
    return part[limit].is_number() ? fmt::format("{}{} {}", number, limit_of(part, limit), key)
                                   : count_of(number, one, key);
  };
  print_wrapped(
      fmt::format("{:<10}", printable(part.value("part", "")) + " use"),
      fmt::format("{:.2f}{} h lit, {}, {} {}", part.value("lamp_h", 0.0), limit_of(part, "lamp_h_limit"),
                  used("layers", "layers_limit", "layer"), used("prints", "prints_limit", "print"), since));
}

int history(const ClientOptions& client, const HistoryOptions& options) {
  if (client.json && options.csv) throw UsageError("--json and --csv exclude each other");
  DaemonConnection connection(client.socket);
  const Json answer = ask(connection, options);
  if (client.json) print_json(answer);
  if (answer.contains("error")) return client.json ? kFailed : print_refusal(answer);
  if (client.json) return kOk;
  const Json& result = answer["result"];
  if (options.csv)
    print_csv(result["ended"]);
  else
    print_lines(result["ended"]);
  if (const std::string trouble = text_of(result, "trouble"); !trouble.empty())
    fmt::print(stderr, "contourctl: only jobs since contourd started are listed: {}\n", trouble);
  return kOk;
}

void print_usage(const Json& usage) {
  if (const std::string trouble = text_of(usage, "trouble"); !trouble.empty())
    return fmt::print("the usage is unknown: {}\n", trouble);
  fmt::print("jobs      {}\nlayers    {}\nlamp      {:.2f} h lit\nresin     {:.2f} ml\n",
             usage.value("jobs", 0), usage.value("layers", 0), usage.value("lamp_h", 0.0),
             usage.value("resin_ml", 0.0));
  for (const Json& each : usage["resins"])
    print_wrapped(
        "          ",
        fmt::format("{:.2f} ml of {}: {}, {}, {:.2f} h lit", each.value("resin_ml", 0.0),
                    printable(each.value("resin", "")), count_of(each.value("jobs", 0U), "job", "jobs"),
                    count_of(each.value("layers", 0U), "layer", "layers"), each.value("lamp_h", 0.0)));
  for (const Json& part : usage["parts"])
    print_part(part);
  for (const Json& part : usage["parts"])
    if (const std::string reminder = text_of(part, "reminder"); !reminder.empty())
      print_wrapped("reminder  ", reminder);
}

}  // namespace

void add_history(Command& program) {
  Command& command = program.add("history", "List the outcomes of the latest jobs");
  auto& options = command.arguments<HistoryOptions>();
  command.option("--last", options.last, "Show at most N jobs").from_to(1, kLongestHistory);
  command.option("--since", options.since, "Show jobs that ended since DATE, or in the last 7d or 12h");
  command.option("--outcome", options.outcome, "Show jobs with this outcome")
      .one_of({"done", "failed", "cancelled"});
  command.option("--resin", options.resin, "Show jobs that were printed with this resin").suggests(resins);
  command.option("--job", options.job, "Show jobs with this text in their names").suggests(all_jobs);
  command.option("--csv", options.csv, "Print CSV, one line per job, for a spreadsheet");
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &options] { return history(client, options); };

  add_request(program, "usage", "Show hours of light, layers and resin so far", "usage", print_usage);

  Command& replaced = program.add("replaced", "Record that the lamp, the film or the vat was replaced");
  auto& part = replaced.arguments<std::string>();
  replaced.option("PART", part, "Replaced part: lamp, film or vat")
      .required()
      .one_of({"lamp", "film", "vat"});
  const ClientOptions& replaced_client = add_client_options(replaced);
  replaced.run = [&replaced_client, &part] {
    return request(replaced_client, {"replaced", {{"part", part}}}, print_usage);
  };
}

}  // namespace contourd::ctl
