// Work on waiting jobs that takes too long for the event loop. Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "daemon/prepare/job_outlook.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

struct JobRefusal {
  std::string reason;
  bool for_now = false;   // true if there may be enough memory later
  std::string profile{};  // problem of the resin profile, for which the job is not refused; or empty
};
// A reading that was given up: for a job whose turn has come, or because no one needs its result any more.
struct ReadingGivenUp {};
// Result of the check of a waiting job.
using CheckedJob = std::variant<JobOutlook, JobRefusal, ReadingGivenUp>;
using JobAnalysisOutcome = std::variant<AnalyzedJob, JobRefusal, ReadingGivenUp>;

// The work that the queue requests. Each function returns at once; `done` is called from the event loop.
class JobChecks {
 public:
  virtual ~JobChecks() = default;

  // Prepares incoming/`file`: `done` gets the reason for a refusal, or the job's outlook. At most one
  // prepared job is cached, until another job is read or a check needs its memory. The check ends early when
  // a job's turn comes, on forget() of this file, and on a check of another file with Keep::Prepared.
  enum class Keep { Nothing, Prepared };
  virtual void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done) = 0;
  // Analyzes all layers of incoming/`file`, which takes as long as computing their masks. Caches the job and
  // ends early as check() does. One analysis at a time.
  virtual void analyze(const std::string& file, Keep keep,
                       std::function<void(const JobAnalysisOutcome&)> done) = 0;
  // Discards the cached preparation of incoming/`file`, and ends its check or analysis early.
  virtual void forget(const std::string& file) = 0;
  // Moves the job to failed/ with a reason file: see Spool::reject().
  virtual void reject(const std::string& file, const JobEnd& end, Spool::Rejected done) = 0;
  // Saves a record of what users have decided about waiting jobs. `done` gets the error; empty on success.
  enum class Record { Order, Accepted };
  virtual void save(Record record, const std::vector<std::string>& lines,
                    std::function<void(const std::string& trouble)> done) = 0;
};

}  // namespace contourd
