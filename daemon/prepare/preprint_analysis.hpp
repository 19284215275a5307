// The analysis of all layers of a job before its turn, and the findings that need the operator's confirmation
// (ask_before in the printer's file). Values; thread-safe (no shared state).
#pragma once

#include <array>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd {

// Result of the analysis.
struct PreprintAnalysis {
  std::optional<double> resin_ml{};   // nullopt if the layers were not analyzed
  std::vector<std::string> findings;  // names, spelled as in ask_before
  std::vector<std::string> warnings;  // about the models, then about the layers; a sentence each
};

// Finding of a job whose layers could not be analyzed. Needs confirmation even if ask_before does not name
// it.
inline constexpr std::string_view kNotAnalyzed = "not_analyzed";
// Finding of a job with places that no support can hold. Needs confirmation even if ask_before does not name
// it.
inline constexpr std::string_view kUnheldPlaces = "unheld_places";
// Finding of a job whose models lack much of their surface. Needs confirmation even if ask_before does not
// name it.
inline constexpr std::string_view kWideGaps = "wide_gaps";
// Finding of a job of an archive's models that do not fit on one plate: some are left out. Needs confirmation
// even if ask_before does not name it.
inline constexpr std::string_view kLeftOutModels = "left_out_models";
// Finding of a job with a model whose size is plausible only in another unit than mm, or whose file names
// another, and whose ticket names none. Needs confirmation even if ask_before does not name it.
inline constexpr std::string_view kUnitInDoubt = "unit_in_doubt";
// Finding of a job with a model that gets supports although its name says that it carries some in its file,
// unless the ticket says which it has. Needs confirmation even if ask_before does not name it.
inline constexpr std::string_view kSupportsInDoubt = "supports_in_doubt";

// Finding of a job whose ticket has it wait until a user accepts it. Needs confirmation even if ask_before
// does not name it.
inline constexpr std::string_view kToBeConfirmed = "to_be_confirmed";

// The findings above that the preparation of a job makes.
inline constexpr std::array<std::string_view, 6> kFoundByPreparation{
    kUnheldPlaces, kWideGaps, kUnitInDoubt, kSupportsInDoubt, kLeftOutModels, kToBeConfirmed};

// An analysis, and the job's content and settings at that time.
struct AnalyzedJob {
  PreprintAnalysis analysis;
  std::string content;  // from content_mark()
  JobSettings settings;
};

// Returns the findings that the preparation alone makes and that need confirmation; nullopt if there are
// none.
[[nodiscard]] std::optional<PreprintAnalysis> analysis_of_preparation(const JobSummary& job);

// Returns the names and warnings of what the preparation and the analysis of the layers found.
[[nodiscard]] PreprintAnalysis preprint_analysis_of(const JobSummary& job, const PrintFindings& findings,
                                                    const PrinterConfig& printer);

// Computes the mask of every layer with the job's analysis engine and returns the findings; nullopt if `stop`
// was requested. An error becomes the finding kNotAnalyzed. Blocks.
[[nodiscard]] std::optional<PreprintAnalysis> analyze_before_print(const PreparedJob& job,
                                                                   const PrinterConfig& printer,
                                                                   const std::stop_token& stop);
// Does the same for at most this time. If it was too short, the findings are those of the preparation, with a
// warning.
[[nodiscard]] std::optional<PreprintAnalysis> analyze_within(Duration limit, const PreparedJob& job,
                                                             const PrinterConfig& printer,
                                                             const std::stop_token& stop);

// Returns the findings that need confirmation on this printer.
[[nodiscard]] std::vector<std::string> asked_findings(const PreprintAnalysis& analysis,
                                                      const PrinterConfig& printer);

// Returns the names as text: "islands, tiny first layer".
[[nodiscard]] std::string findings_text(const std::vector<std::string>& names);

}  // namespace contourd
