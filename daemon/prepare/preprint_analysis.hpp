// What a look through all layers of a job has found before its turn, and which of it the printer's owner
// wants to be asked about (ask_before in the printer's file). Values; thread-safe (no shared state).
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd {

struct PreprintAnalysis {
  std::optional<double> resin_ml{};   // nothing where the layers were not looked through
  std::vector<std::string> findings;  // their names, as ask_before has them
  std::vector<std::string> warnings;  // about the models, then about the layers; a sentence each
};

// The finding of a job whose layers could not be looked through. The owner is asked about it whatever
// ask_before names.
inline constexpr std::string_view kNotAnalyzed = "not_analyzed";
// The same of one with places that have to be held and cannot be.
inline constexpr std::string_view kUnheldPlaces = "unheld_places";

// A job of whose findings its owner may be asked, as it was then.
struct AnalyzedJob {
  PreprintAnalysis analysis;
  std::string content;  // as content_mark() has it
  JobSettings settings;
};

// What its preparation alone has found of which its owner is asked; nothing when there is none.
[[nodiscard]] std::optional<PreprintAnalysis> analysis_of_preparation(const JobSummary& job);

[[nodiscard]] PreprintAnalysis preprint_analysis_of(const JobSummary& job, const PrintFindings& findings,
                                                    const PrinterConfig& printer);

// Computes the mask of every layer, by the job's analysis engine. What goes wrong there is a finding. Nothing
// when `stop` was asked for meanwhile. Blocks.
[[nodiscard]] std::optional<PreprintAnalysis> analyze_before_print(const PreparedJob& job,
                                                                   const PrinterConfig& printer,
                                                                   const std::stop_token& stop);

// Those of a job's findings that the printer's owner wants to be asked about.
[[nodiscard]] std::vector<std::string> asked_findings(const PreprintAnalysis& analysis,
                                                      const PrinterConfig& printer);

// For people: "islands, tiny first layer".
[[nodiscard]] std::string findings_text(const std::vector<std::string>& names);

}  // namespace contourd
