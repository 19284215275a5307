#include "daemon/control/history_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>
#include <vector>

#include "daemon/system/readable.hpp"

namespace contourd {

using Json = HistoryControl::Json;
using std::chrono::system_clock;

namespace {

// The year 2200, which the clock's type can still represent.
constexpr std::time_t kLatest = 7'258'118'400;
constexpr std::array<std::string_view, 3> kOutcomes{"done", "failed", "cancelled"};

std::size_t last_of(const Json& given) {
  const auto last = given.find("last");
  if (last == given.end()) return HistoryControl::kLongestPage;
  if (!last->is_number_integer() || *last < 1 || *last > HistoryControl::kLongestPage)
    throw InvalidParameters(
        fmt::format("last must be a whole number from 1 to {}", HistoryControl::kLongestPage));
  return last->get<std::size_t>();
}

std::optional<std::string> text_of(const Json& given, const char* name) {
  const auto found = given.find(name);
  if (found == given.end()) return std::nullopt;
  if (!found->is_string() || found->get_ref<const std::string&>().empty())
    throw InvalidParameters(fmt::format("{} must be a text that is not empty", name));
  return found->get<std::string>();
}

std::optional<std::string> outcome_of(const Json& given) {
  const std::optional<std::string> outcome = text_of(given, "outcome");
  if (outcome && std::ranges::find(kOutcomes, *outcome) == kOutcomes.end())
    throw InvalidParameters(fmt::format("outcome must be one of {}", fmt::join(kOutcomes, ", ")));
  return outcome;
}

std::optional<system_clock::time_point> since_of(const Json& given) {
  const std::optional<std::string> text = text_of(given, "since");
  if (!text) return std::nullopt;
  std::tm time{};
  const char* const end = ::strptime(text->c_str(), "%Y-%m-%dT%H:%M:%SZ", &time);
  const std::time_t seconds = ::timegm(&time);
  if (end == nullptr || end != text->c_str() + text->size() || seconds < 0 || seconds > kLatest)
    throw InvalidParameters("since must be a time such as 2026-11-20T19:05:00Z");
  return system_clock::from_time_t(seconds);
}

std::optional<std::int64_t> before_of(const Json& given) {
  const auto before = given.find("before");
  if (before == given.end()) return std::nullopt;
  if (!before->is_number_integer() || *before < 1)
    throw InvalidParameters("before must be a whole number above 0, taken from the previous reply");
  return before->get<std::int64_t>();
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

Json json_text(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

Json reply(HistoryPage page, const std::string& trouble) {
  return {{"ended", std::move(page.jobs)},
          {"before", page.before ? Json(*page.before) : Json()},
          {"trouble", json_text(trouble)}};
}

constexpr double kSecondsPerHour = 3600;
constexpr const char* kDisconnected = "the client has disconnected";

WearPart part_of(const Json& given) {
  const auto name = given.find("part");
  const auto* const part = std::ranges::find_if(kWearParts, [&](WearPart each) {
    return name != given.end() && name->is_string() && name->get_ref<const std::string&>() == name_of(each);
  });
  if (part == kWearParts.end()) throw InvalidParameters("part must be one of lamp, film, vat");
  return *part;
}

template <typename Number>
Json or_null(const std::optional<Number>& number) {
  return number ? Json(*number) : Json();
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
          {"reminder", json_text(reminder_of(use, limits))}};
}

}  // namespace

ControlMethods HistoryControl::methods() {
  ControlMethod jobs, used, replaced;
  jobs.parameters = {"last", "before", "since", "outcome", "resin", "job", "this_run"};
  jobs.call_later = [this](const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
    return history(given, caller, std::move(later));
  };
  used.call_later = [this](const Json&, const ControlCaller& caller, ControlMethod::Later later) {
    return usage(caller, std::move(later));
  };
  replaced.parameters = {"part"};
  replaced.changes = true;
  replaced.call_later = [this](const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
    return replace(given, caller, std::move(later));
  };
  return {{"history", std::move(jobs)}, {"usage", std::move(used)}, {"replaced", std::move(replaced)}};
}

std::optional<Json> HistoryControl::history(const Json& given, const ControlCaller& caller,
                                            ControlMethod::Later later) {
  const HistoryQuery query{.last = last_of(given),
                           .before = before_of(given),
                           .since = since_of(given),
                           .outcome = outcome_of(given),
                           .resin = text_of(given, "resin"),
                           .name = text_of(given, "job")};
  if (const auto this_run = given.find("this_run"); this_run != given.end()) {
    if (!this_run->is_boolean()) throw InvalidParameters("this_run must be true or false");
    if (this_run->get<bool>()) return reply(recent_jobs(recent_, query), "");
  }
  worker_.list(query, caller,
               [this, query, later = std::move(later)](const std::optional<HistoryPage>& page,
                                                       const std::string& trouble) {
                 if (!page && trouble.empty()) return later(ControlRefusal(kDisconnected));
                 later(page ? reply(*page, "") : reply(recent_jobs(recent_, query), trouble));
               });
  return std::nullopt;
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
  return {{"jobs", all.jobs},
          {"layers", all.layers},
          {"lamp_h", all.lit_s / kSecondsPerHour},
          {"resin_ml", all.resin_ml},
          {"resins", std::move(resins)},
          {"parts", std::move(parts)},
          {"trouble", json_text(trouble)}};
}

std::optional<Json> HistoryControl::usage(const ControlCaller& caller, ControlMethod::Later later) {
  worker_.usage(caller, [this, later = std::move(later)](const std::optional<HistoryWorker::AllUsage>& usage,
                                                         const std::string& trouble) {
    if (!usage && trouble.empty()) return later(ControlRefusal(kDisconnected));
    later(usage_reply(usage, trouble));
  });
  return std::nullopt;
}

std::optional<Json> HistoryControl::replace(const Json& given, const ControlCaller& caller,
                                            ControlMethod::Later later) {
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
  return std::nullopt;
}

}  // namespace contourd
