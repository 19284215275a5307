// What a printer's owner is asked about the jobs that wait: which of them have findings that the printer's
// file names (ask_before), or that are asked about whatever it names, and what was accepted. Event loop's
// thread only.
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
    // Looks through incoming/`file`, and calls `done` from the loop: see JobReader::analyze(). Empty where
    // the printer's file names nothing.
    std::function<void(const std::string& file, JobReader::Keep keep,
                       std::function<void(const JobAnalysisOutcome&)> done)>
        analyze{};
    // Which of what was found is to be asked about.
    std::function<std::vector<std::string>(const PreprintAnalysis&)> asked{};
    RecordKeeper::Keep keep_accepted{};
    // A job asks now, or does not any more.
    std::function<void()> changed{};
  };
  // The log must outlive the questions.
  JobQuestions(const Log& log, Calls calls);

  // Whether jobs are looked through, and may wait for their owners, whatever they are.
  [[nodiscard]] bool wanted() const { return static_cast<bool>(calls_.analyze); }
  // What was accepted when the last process ended.
  void load_accepted(std::vector<std::string> lines) { acceptances_.load(std::move(lines)); }

  // REQUIRES: wanted().
  void analyze(const std::string& file, JobReader::Keep keep,
               std::function<void(const JobAnalysisOutcome&)> done) const;
  // Those findings that its owner has not accepted.
  [[nodiscard]] std::vector<std::string> about(const AnalyzedJob& job) const;
  void tell_change() const { calls_.changed(); }
  // They are accepted.
  void accept(const AnalyzedJob& job, const std::vector<std::string>& findings);

  // Whether the job's owner has accepted this, as it was then.
  [[nodiscard]] bool has_accepted(const std::optional<AnalyzedJob>& job, const std::string& finding) const {
    return job && acceptances_.has(job->content, finding);
  }

  // Whether the job's files and settings are those that were looked through, where that is wanted or was
  // done.
  [[nodiscard]] bool knows(const std::optional<AnalyzedJob>& job, const JobFiles& files,
                           const std::optional<JobSettings>& settings) const;

  // A job's turn has come: what was accepted of it is forgotten with ended(), so that it is known as long as
  // the job may come back.
  void begun(const std::optional<AnalyzedJob>& job) { begun_ = job ? job->content : ""; }
  void ended();

 private:
  Calls calls_;
  Acceptances acceptances_;
  std::string begun_;  // the content of the job that has begun
};

// What the owner of incoming/`file` is asked about these findings, and what goes on with it; empty when there
// are none.
[[nodiscard]] std::string question_about(const std::string& file, const std::vector<std::string>& findings);

}  // namespace contourd
