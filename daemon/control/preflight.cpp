#include "daemon/control/preflight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/jobs/job_questions.hpp"
#include "daemon/report/time_causes.hpp"

namespace contourd {
namespace {

constexpr std::size_t kMostFindings = 20;

PreflightCheck check_model(const WaitingJob& job) {
  if (job.check == WaitingJob::Check::Refused)
    return {"model", Verdict::Refuse, "it is on its way to failed"};
  if (!job.trouble.empty()) return {"model", Verdict::Refuse, job.trouble};
  if (!job.postponed.empty()) return {"model", Verdict::Warn, "it is checked later: " + job.postponed};
  if (!job.outlook) return {"model", Verdict::Warn, "it is not checked yet"};
  return {
      "model", Verdict::Pass,
      fmt::format("{} layers, {:.2f} mm high, fit the machine", job.outlook->layers, job.outlook->height_mm)};
}

PreflightCheck check_time(const WaitingJob& job) {
  if (!job.outlook) return {"time", Verdict::Pass, "it is known once the job is checked"};
  return {"time", Verdict::Pass, causes_line(job.outlook->forecast.time)};
}

PreflightCheck check_resin(const WaitingJob& job, const std::optional<double>& vat_ml) {
  constexpr double kUnknown = -1;
  const double needed_ml = job.analyzed ? job.analyzed->analysis.resin_ml.value_or(kUnknown) : kUnknown;
  if (!vat_ml)
    return {"resin", Verdict::Warn, "contourd does not know what the vat holds: contourctl vat filled ML"};
  const std::string held = fmt::format("the vat holds about {:.0f} ml", *vat_ml);
  if (needed_ml == kUnknown)
    return {"resin", Verdict::Warn, held + "; what the job needs is known once it is analyzed"};
  const Verdict verdict = needed_ml > *vat_ml ? Verdict::Warn : Verdict::Pass;
  return {"resin", verdict, fmt::format("{}, the job needs {:.1f} ml", held, needed_ml)};
}

// Returns a check that refuses with this reason, or passes with `fine` if there is none.
PreflightCheck refused_by(std::string_view name, const std::string& reason, const std::string& fine) {
  if (reason.empty()) return {name, Verdict::Pass, fine};
  return {name, Verdict::Refuse, reason};
}

PreflightCheck check_temperature(const PreflightFacts& facts) {
  if (!facts.resin_trouble.empty()) return {"temperature", Verdict::Warn, facts.resin_trouble};
  if (!facts.resin_c) return {"temperature", Verdict::Pass, "no resin_temperature is configured"};
  return {"temperature", Verdict::Pass, fmt::format("the resin has {:.1f} degrees C", *facts.resin_c)};
}

PreflightCheck check_wear(const PreflightFacts& facts) {
  if (!facts.due.empty()) return {"wear", Verdict::Warn, facts.due.front()};
  std::string text;
  for (const WearPartUse& use : facts.wear) {
    if (use.part == WearPart::Vat) continue;
    text += fmt::format("{}{} {:.1f} h of light, {} layers", text.empty() ? "" : "; ", name_of(use.part),
                        use.lamp_h, use.layers);
  }
  return {"wear", Verdict::Pass, text.empty() ? "the use of lamp and film is not known" : text};
}

void add_findings(const WaitingJob& job, std::vector<PreflightCheck>& checks) {
  if (!job.asks.empty()) checks.push_back({"findings", Verdict::Refuse, question_about(job.file, job.asks)});
  if (!job.analyzed) {
    checks.push_back({"findings", Verdict::Pass, "its layers are analyzed while it prints"});
    return;
  }
  const std::vector<std::string>& warnings = job.analyzed->analysis.warnings;
  for (std::size_t i = 0; i < std::min(warnings.size(), kMostFindings); ++i)
    checks.push_back({"findings", Verdict::Warn, warnings[i]});
  if (warnings.size() > kMostFindings)
    checks.push_back(
        {"findings", Verdict::Warn, fmt::format("and {} more", warnings.size() - kMostFindings)});
  if (warnings.empty() && job.asks.empty()) checks.push_back({"findings", Verdict::Pass, "none"});
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::Pass:
      return "pass";
    case Verdict::Warn:
      return "warn";
    case Verdict::Refuse:
      return "refuse";
  }
  return "?";
}

std::vector<PreflightCheck> preflight(const WaitingJob& job, const PreflightFacts& facts) {
  std::vector<PreflightCheck> checks{
      check_model(job),
      check_time(job),
      check_resin(job, facts.vat_ml),
      refused_by("machine", facts.not_ready, "switches, projector and axis are ready"),
      {"display", Verdict::Pass, facts.display},
      refused_by("disk", facts.disk_trouble, "there is room for the print's files"),
      refused_by("queue", facts.queue_waits, "nothing keeps the next job waiting"),
      check_temperature(facts),
      check_wear(facts)};
  add_findings(job, checks);
  return checks;
}

nlohmann::ordered_json preflight_json(const std::string& job, const std::vector<PreflightCheck>& checks) {
  auto list = nlohmann::ordered_json::array();
  Verdict worst = Verdict::Pass;
  for (const PreflightCheck& each : checks) {
    worst = std::max(worst, each.verdict);
    list.push_back({{"check", each.name}, {"verdict", name_of(each.verdict)}, {"text", each.text}});
  }
  return {{"file", job}, {"verdict", name_of(worst)}, {"checks", std::move(list)}};
}

}  // namespace contourd
