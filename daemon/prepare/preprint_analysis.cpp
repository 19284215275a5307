#include "daemon/prepare/preprint_analysis.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "daemon/prepare/print_findings.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns the findings of the preparation that need confirmation whatever ask_before names.
std::vector<std::string> always_asked(const JobSummary& job) {
  std::vector<std::string> findings;
  if (job.supports && !job.supports->unheld.empty()) findings.emplace_back(kUnheldPlaces);
  if (!job.wide_gaps.empty()) findings.emplace_back(kWideGaps);
  if (!job.unit_question.empty()) findings.emplace_back(kUnitInDoubt);
  if (!job.supports_question.empty()) findings.emplace_back(kSupportsInDoubt);
  if (!job.left_out.empty()) findings.emplace_back(kLeftOutModels);
  if (job.confirm) findings.emplace_back(kToBeConfirmed);
  return findings;
}

// Limits of the warnings, since every request for the queue sends them all.
constexpr std::size_t kMaxWarnings = 20, kLongestWarning = 500;

void bound(std::vector<std::string>& warnings) {
  const std::size_t all = warnings.size();
  if (all > kMaxWarnings) {
    warnings.resize(kMaxWarnings - 1);
    warnings.push_back(fmt::format("and {} more warnings", all - warnings.size()));
  }
  for (std::string& warning : warnings)
    warning = shortened(warning, kLongestWarning);
}

// Returns the area of the first layer, which holds the part on the plate, in percent of the largest layer,
// where the peel pulls hardest.
double first_layer_percent(const PrintFindings& findings) {
  if (findings.area_mm2.empty() || findings.largest_area_mm2 <= 0) return 100;
  return 100 * findings.area_mm2.front() / findings.largest_area_mm2;
}

// Returns what the preparation alone has found.
PreprintAnalysis analysis_of(const JobSummary& job) {
  return {.resin_ml = {}, .findings = always_asked(job), .warnings = job.warnings};
}

// Computes the mask of every layer. Calls `before_layer` before each.
template <typename BeforeLayer>
std::optional<PreprintAnalysis> analyze_layers(const PreparedJob& job, const PrinterConfig& printer,
                                               const std::stop_token& stop, BeforeLayer before_layer) {
  try {
    const std::vector<Duration> durations = layer_durations(job.plan, printer);
    const auto findings = analyze_print(
        *job.analysis_engine, job.display, job.plan.expected_layers,
        [&](std::int32_t layer) {
          before_layer();
          return durations[static_cast<std::size_t>(layer)];
        },
        stop, job.analysis);
    if (!findings) return std::nullopt;
    return preprint_analysis_of(job.summary, *findings, printer);
  } catch (const std::exception& error) {
    PreprintAnalysis analysis = analysis_of(job.summary);
    analysis.findings.emplace_back(kNotAnalyzed);
    analysis.warnings.push_back(fmt::format("the layers could not be analyzed: {}", printable(error.what())));
    bound(analysis.warnings);
    return analysis;
  }
}

}  // namespace

std::optional<PreprintAnalysis> analysis_of_preparation(const JobSummary& job) {
  PreprintAnalysis analysis = analysis_of(job);
  if (analysis.findings.empty()) return std::nullopt;
  bound(analysis.warnings);
  return analysis;
}

PreprintAnalysis preprint_analysis_of(const JobSummary& job, const PrintFindings& findings,
                                      const PrinterConfig& printer) {
  PreprintAnalysis analysis{
      .resin_ml = findings.resin_ml(), .findings = always_asked(job), .warnings = job.warnings};
  const auto note = [&analysis](bool found, std::string_view name) {
    if (found) analysis.findings.emplace_back(name);
  };
  const double percent = first_layer_percent(findings);
  const bool tiny = percent < printer.tiny_first_layer_percent;
  note(findings.island_count > 0, "islands");
  note(findings.suction_cup_count > 0, "suction_cups");
  note(findings.resin_trap_count > 0, "resin_traps");
  note(tiny, "tiny_first_layer");
  note(findings.cracks.open_chains > 0 || findings.cracks.turned_chains > 0 ||
           std::ranges::any_of(job.models, &MeshRepairs::has_guesses, &ModelSummary::repairs),
       "cracks");
  note(!std::ranges::all_of(job.models, &MeshReport::watertight, &ModelSummary::mesh), "not_watertight");
  note(std::ranges::any_of(job.models, &ShellReport::any, &ModelSummary::shells), "inverted_shells");
  note(!findings.empty_layers.empty(), "empty_layers");
  note(!findings.abandoned_layers.empty(), "abandoned_layers");
  if (tiny)
    analysis.warnings.push_back(fmt::format(
        "layer 1 is tiny: it covers {:.2f} mm², {:.1f} % of layer {}, the largest: the part may come off "
        "the plate",
        findings.area_mm2.front(), percent, findings.largest_area_layer + 1));
  for (std::string& warning : warnings_about(findings))
    analysis.warnings.push_back(std::move(warning));
  bound(analysis.warnings);
  return analysis;
}

std::optional<PreprintAnalysis> analyze_before_print(const PreparedJob& job, const PrinterConfig& printer,
                                                     const std::stop_token& stop) {
  return analyze_layers(job, printer, stop, [] {});
}

std::optional<PreprintAnalysis> analyze_within(Duration limit, const PreparedJob& job,
                                               const PrinterConfig& printer, const std::stop_token& stop) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  std::stop_source ended;
  std::optional<PreprintAnalysis> analysis = analyze_layers(job, printer, ended.get_token(), [&] {
    if (stop.stop_requested() || std::chrono::steady_clock::now() > deadline) ended.request_stop();
  });
  if (stop.stop_requested()) return std::nullopt;
  if (analysis && !ended.stop_requested()) return analysis;
  analysis = analysis_of(job.summary);
  analysis->warnings.push_back(
      fmt::format("the amount of resin is unknown: not all layers were analyzed within {}", readable(limit)));
  bound(analysis->warnings);
  return analysis;
}

std::vector<std::string> asked_findings(const PreprintAnalysis& analysis, const PrinterConfig& printer) {
  std::vector<std::string> asked = analysis.findings;
  std::erase_if(asked, [&](const std::string& name) {
    if (name == kNotAnalyzed || std::ranges::find(kFoundByPreparation, name) != kFoundByPreparation.end())
      return false;
    return std::ranges::find(printer.ask_before, name) == printer.ask_before.end();
  });
  return asked;
}

std::string findings_text(const std::vector<std::string>& names) {
  std::string text = fmt::format("{}", fmt::join(names, ", "));
  std::ranges::replace(text, '_', ' ');
  return text;
}

}  // namespace contourd
