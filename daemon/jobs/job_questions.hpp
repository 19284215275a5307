// Questions to the user about waiting jobs: which findings need confirmation (those that ask_before in the
// printer's file names, and some that always do), and which of them were accepted. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/jobs/acceptances.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class JobQuestions {
 public:
  struct Calls {
    // Analyzes all layers of incoming/`file`, and calls `done` from the loop: see JobReader::analyze(). Empty
    // if ask_before names no findings.
    std::function<void(const std::string& file, JobReader::Keep keep,
                       std::function<void(const JobAnalysisOutcome&)> done)>
        analyze{};
    // Returns the findings that need confirmation.
    std::function<std::vector<std::string>(const PreprintAnalysis&)> asked{};
    RecordKeeper::Keep keep_accepted{};
    // Reports that a job began or stopped waiting for confirmation.
    std::function<void()> changed{};
  };
  // The log must outlive the questions.
  JobQuestions(const Log& log, Calls calls);

  // True if all layers of every job are analyzed before it begins, because ask_before names findings.
  [[nodiscard]] bool wanted() const { return static_cast<bool>(calls_.analyze); }
  // Restores the acceptances that the last process saved.
  void load_accepted(std::vector<std::string> lines) { acceptances_.load(std::move(lines)); }

  // Starts an analysis: see Calls::analyze. REQUIRES: wanted().
  void analyze(const std::string& file, JobReader::Keep keep,
               std::function<void(const JobAnalysisOutcome&)> done) const;
  // Returns the job's findings that need confirmation and were not accepted yet.
  [[nodiscard]] std::vector<std::string> about(const AnalyzedJob& job) const;
  void tell_change() const { calls_.changed(); }
  // Records that a user accepted these findings.
  void accept(const AnalyzedJob& job, const std::vector<std::string>& findings);

  // True if a user has accepted this finding for the job's present content.
  [[nodiscard]] bool has_accepted(const std::optional<AnalyzedJob>& job, const std::string& finding) const {
    return job && acceptances_.has(job->content, finding);
  }

  // True if the job's files and settings are those that were analyzed, or if no analysis is wanted and none
  // was made.
  [[nodiscard]] bool knows(const std::optional<AnalyzedJob>& job, const JobFiles& files,
                           const std::optional<JobSettings>& settings) const;

  // Notes that the job's turn has come. Its acceptances are kept until ended(), because until then the job
  // may return to the queue.
  void begun(const std::optional<AnalyzedJob>& job) { begun_ = job ? job->content : ""; }
  // Forgets the acceptances of the job that has begun.
  void ended();

 private:
  Calls calls_;
  Acceptances acceptances_;
  std::string begun_;  // the content of the job that has begun
};

// Returns the question about these findings of incoming/`file`, with the command that accepts them; empty if
// there are none.
[[nodiscard]] std::string question_about(const std::string& file, const std::vector<std::string>& findings);

}  // namespace contourd
