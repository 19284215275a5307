#include "daemon/control/history_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <vector>

#include "daemon/system/readable.hpp"

namespace contourd {

using Json = HistoryControl::Json;
using std::chrono::system_clock;

namespace {

// The year 2200, which the clock's type can still represent.
constexpr std::time_t kLatest = 7'258'118'400;
constexpr const char* kTimeInWords = "a time such as 2026-11-20T19:05:00Z";

std::optional<system_clock::time_point> since_of(const Json& given) {
  const std::optional<std::string> text = given_value<std::string>(given, "since");
  if (!text) return std::nullopt;
  std::tm time{};
  const char* const end = ::strptime(text->c_str(), "%Y-%m-%dT%H:%M:%SZ", &time);
  const std::time_t seconds = ::timegm(&time);
  if (end == nullptr || end != text->c_str() + text->size() || seconds < 0 || seconds > kLatest)
    throw InvalidParameters(fmt::format("since must be {}", kTimeInWords));
  return system_clock::from_time_t(seconds);
}

std::size_t bytes_of(const Json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace).size();
}

bool is_wanted(const EndedJob& job, const HistoryQuery& query) {
  return (!query.since || job.ended >= *query.since) && (!query.outcome || job.outcome == *query.outcome) &&
         (!query.resin || job.figures.resin == *query.resin) &&
         (!query.name || job.name.find(*query.name) != std::string::npos);
}

// Returns a page of the jobs that are remembered without the database. Jobs are numbered in the order in
// which they ended since contourd started.
HistoryPage recent_jobs(const JobHistory& recent, const HistoryQuery& query) {
  HistoryPage page;
  std::vector<Json> found;
  std::size_t bytes = 0;
  std::int64_t number = recent.total() + 1, earliest = 0;
  for (auto job = recent.jobs().rbegin(); job != recent.jobs().rend(); ++job) {
    --number;
    if (number >= query.before.value_or(INT64_MAX) || !is_wanted(*job, query)) continue;
    if (found.size() == query.last || bytes > HistoryPage::kMostBytes) {
      page.before = earliest;
      break;
    }
    found.push_back(history_json(*job));
    bytes += bytes_of(found.back());
    earliest = number;
  }
  std::ranges::move(found.rbegin(), found.rend(), std::back_inserter(page.jobs.get_ref<Json::array_t&>()));
  return page;
}

Json reply(HistoryPage page, const std::string& trouble) {
  return {{"ended", std::move(page.jobs)}, {"before", or_null(page.before)}, {"trouble", or_null(trouble)}};
}

constexpr double kSecondsPerHour = 3600;
constexpr const char* kDisconnected = "the client has disconnected";

WearPart part_of(const Json& given) {
  return *std::ranges::find(kWearParts, given["part"].get<std::string>(), name_of);
}

std::vector<std::string> wear_part_names() {
  std::vector<std::string> names;
  for (const WearPart each : kWearParts)
    names.emplace_back(name_of(each));
  return names;
}

Json part_json(const WearPartUse& use, const WearLimits& limits) {
  return {{"part", name_of(use.part)},
          {"replaced", use.replaced ? Json(iso_time(*use.replaced)) : Json()},
          {"lamp_h", use.lamp_h},
          {"layers", use.layers},
          {"prints", use.prints},
          {"lamp_h_limit", or_null(limits.lamp_h)},
          {"layers_limit", or_null(limits.layers)},
          {"prints_limit", or_null(limits.prints)},
          {"reminder", or_null(reminder_of(use, limits))}};
}

}  // namespace

ControlMethods HistoryControl::methods() {
  using Parameter = ControlParameter;
  return {
      {"history",
       {.description =
            "Reports the jobs that have ended, the latest last, from contourd's database, including "
            "earlier runs.",
        .parameters =
            {Parameter::whole_number("last", 1, kLongestPage,
                                     "maximum number of jobs, by default the largest"),
             Parameter::whole_number("before", 1, Parameter::kMost,
                                     "only earlier jobs: the number of this name in the previous reply")
                 .described_as("a whole number above 0, taken from the previous reply"),
             Parameter::text("since", "only jobs that ended at this time, in UTC, or later")
                 .described_as(kTimeInWords),
             Parameter::one_of("outcome", {"done", "failed", "cancelled"}, "only jobs with this outcome"),
             Parameter::text("resin", "only jobs that were printed with this resin"),
             Parameter::text("job", "only jobs with this text in their names"),
             Parameter::flag("this_run", "only jobs that ended since contourd started, which needs no disk")},
        .call_later = [this](
                          const Json& given, const ControlCaller& caller,
                          ControlMethod::Later later) { return history(given, caller, std::move(later)); }}},
      {"usage",
       {.description = "Reports the total use of all jobs so far, including interrupted jobs.",
        .call_later = [this](const Json&, const ControlCaller& caller,
                             ControlMethod::Later later) { return usage(caller, std::move(later)); }}},
      {"replaced",
       {.description = "Records that a part of the machine is new: its use counts from now on.",
        .parameters = {Parameter::one_of("part", wear_part_names(), "the new part").needed()},
        .changes = true,
        .call_later = [this](const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
          return replace(given, caller, std::move(later));
        }}}};
}

void HistoryControl::history(const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
  const HistoryQuery query{.last = given.value("last", kLongestPage),
                           .before = given_value<std::int64_t>(given, "before"),
                           .since = since_of(given),
                           .outcome = given_value<std::string>(given, "outcome"),
                           .resin = given_value<std::string>(given, "resin"),
                           .name = given_value<std::string>(given, "job")};
  if (given.value("this_run", false)) return later(reply(recent_jobs(recent_, query), ""));
  worker_.list(query, caller,
               [this, query, later = std::move(later)](const std::optional<HistoryPage>& page,
                                                       const std::string& trouble) {
                 if (!page && trouble.empty()) return later(ControlRefusal(kDisconnected));
                 later(page ? reply(*page, "") : reply(recent_jobs(recent_, query), trouble));
               });
}

Json HistoryControl::usage_reply(const std::optional<HistoryWorker::AllUsage>& usage,
                                 const std::string& trouble) const {
  const Usage all = usage ? usage->all : Usage{};
  Json resins = Json::array(), parts = Json::array();
  for (const Usage& each : usage ? usage->by_resin : std::vector<Usage>{}) {
    resins.push_back({{"resin", each.resin},
                      {"jobs", each.jobs},
                      {"layers", each.layers},
                      {"lamp_h", each.lit_s / kSecondsPerHour},
                      {"resin_ml", each.resin_ml}});
  }
  for (const WearPartUse& each : usage ? usage->wear : std::vector<WearPartUse>{})
    parts.push_back(part_json(each, reminders_.limits(each.part)));
  return {
      {"jobs", all.jobs},           {"layers", all.layers},        {"lamp_h", all.lit_s / kSecondsPerHour},
      {"resin_ml", all.resin_ml},   {"resins", std::move(resins)}, {"parts", std::move(parts)},
      {"trouble", or_null(trouble)}};
}

void HistoryControl::usage(const ControlCaller& caller, ControlMethod::Later later) {
  worker_.usage(caller, [this, later = std::move(later)](const std::optional<HistoryWorker::AllUsage>& usage,
                                                         const std::string& trouble) {
    if (!usage && trouble.empty()) return later(ControlRefusal(kDisconnected));
    later(usage_reply(usage, trouble));
  });
}

void HistoryControl::replace(const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
  const WearPart part = part_of(given);
  worker_.replace(
      part, caller,
      [this, part, later = std::move(later)](const std::optional<HistoryWorker::AllUsage>& usage,
                                             const std::string& trouble) {
        if (!usage)
          return later(ControlRefusal(trouble.empty() ? kDisconnected : trouble + "; nothing is recorded"));
        reminders_.update(usage->wear);
        later(usage_reply(usage, trouble));
        replaced_(part);
      });
}

}  // namespace contourd
