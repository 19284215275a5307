// Questions to the user about waiting jobs: which findings need confirmation (those that ask_before in the
// printer's file names, and some that always do), and which of them were accepted. Event loop's thread only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/jobs/acceptances.hpp"
#include "daemon/prepare/preprint_analysis.hpp"

namespace contourd {

class JobQuestions {
 public:
  // All arguments must outlive the questions.
  JobQuestions(const PrinterConfig& config, JobChecks& checks, const Log& log)
      : config_(config), acceptances_(checks, log) {}

  // True if all layers of every job are analyzed before it begins, because ask_before names findings.
  [[nodiscard]] bool wanted() const { return !config_.ask_before.empty(); }
  // Restores the acceptances that the last process saved.
  void load_accepted(std::vector<std::string> lines) { acceptances_.load(std::move(lines)); }

  // Returns the job's findings that need confirmation and were not accepted yet.
  [[nodiscard]] std::vector<std::string> about(const AnalyzedJob& job) const;
  // Records that a user accepted these findings.
  void accept(const AnalyzedJob& job, const std::vector<std::string>& findings) {
    acceptances_.add(job.content, findings);
  }
  // True if a user has accepted this finding for the job's present content.
  [[nodiscard]] bool has_accepted(const std::optional<AnalyzedJob>& job, const std::string& finding) const {
    return job && acceptances_.has(job->content, finding);
  }

  // True if the job's content (see content_mark()) and settings are those that were analyzed, or if no
  // analysis is wanted and none was made.
  [[nodiscard]] bool knows(const std::optional<AnalyzedJob>& job, const std::string& content,
                           const std::optional<JobSettings>& settings) const;

  // Forgets that a user has confirmed the job (to_be_confirmed): what the user saw is not what would be
  // printed. Returns true if one had.
  bool withdraw_confirmation(const AnalyzedJob& job);

  // Notes that the job's turn has come. Its acceptances are kept until ended(), because until then the job
  // may return to the queue.
  void begun(const std::optional<AnalyzedJob>& job) { begun_ = job ? job->content : ""; }
  // Forgets the acceptances of the job that has begun.
  void ended();

 private:
  const PrinterConfig& config_;
  Acceptances acceptances_;
  std::string begun_;  // the content of the job that has begun
};

// Returns the question about these findings of incoming/`file`, with the command that accepts them; empty if
// there are none.
[[nodiscard]] std::string question_about(const std::string& file, const std::vector<std::string>& findings);

}  // namespace contourd
