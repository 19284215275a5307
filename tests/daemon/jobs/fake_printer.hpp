// Fakes of the interfaces between the queue and the rest of the printer. Not thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/jobs/job_checks.hpp"
#include "daemon/jobs/job_claims.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_use.hpp"

namespace contourd::testing {

using Names = std::vector<std::string>;

// Work on waiting jobs that ends when a test calls `done`, or at once if the test has set its result.
class FakeChecks final : public JobChecks {
 public:
  template <typename Result>
  struct Running {
    std::string file;
    Keep keep;
    std::function<void(const Result&)> done;
  };
  struct Rejection {
    std::string file, reason;
    Spool::Rejected done;
  };

  void check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done) override {
    checks.push_back({file, keep, done});
    if (check_result) done(*check_result);
  }
  void analyze(const std::string& file, Keep keep,
               std::function<void(const JobAnalysisOutcome&)> done) override {
    analyses.push_back({file, keep, done});
    if (analysis_result) done(analysis_result(file));
  }
  void forget(const std::string& file) override { forgotten.push_back(file); }
  void reject(const std::string& file, const JobEnd& end, Spool::Rejected done) override {
    rejections.push_back({file, end.reason, std::move(done)});
  }
  void save(Record /*record*/, const Names& lines, std::function<void(const std::string&)> done) override {
    saved.push_back(lines);
    if (saves_end) return done("");
    save_done = std::move(done);
  }

  std::optional<CheckedJob> check_result;
  std::function<JobAnalysisOutcome(const std::string& file)> analysis_result;
  bool saves_end = false;

  std::vector<Running<CheckedJob>> checks;
  std::vector<Running<JobAnalysisOutcome>> analyses;
  std::vector<Rejection> rejections;
  Names forgotten;
  std::vector<Names> saved;
  std::function<void(const std::string&)> save_done;  // ends the last save
};

// Looks at jobs and claims them at once, on the caller's thread.
class BlockingClaims final : public JobClaims {
 public:
  BlockingClaims(Spool& spool, const PrinterConfig& config) : spool_(spool), config_(config) {}
  void look(const std::string& file, std::function<void(const JobLook&)> done) override {
    JobLook look = look_at(spool_, file, config_);
    if (after_look) after_look();
    done(look);
  }
  void claim(const std::string& file, std::function<void(const Claim&)> done) override {
    done(claim_now(spool_, file));
  }

  std::function<void()> after_look;  // what happens between a look and its report

 private:
  Spool& spool_;
  const PrinterConfig& config_;
};

class FakeQueueObserver final : public QueueObserver {
 public:
  void queue_changed() override {
    reported.emplace_back("changed");
    if (on_change) on_change();
  }
  void question_changed() override { ++question_changes; }
  void job_refused(EndedJob job) override {
    reported.push_back(job.name + " " + job.outcome + ": " + job.reason);
  }

  std::function<void()> on_change;
  Names reported;  // "changed", or "JOB OUTCOME: REASON"
  int question_changes = 0;
};

// A printer that a test sets to be in use, and which keeps the jobs that begin.
class FakePrinter final : public PrinterUse {
 public:
  [[nodiscard]] bool has_job() const override { return job; }
  [[nodiscard]] bool controlled_by_hand() const override { return by_hand; }
  void begin(ClaimedJob claimed) override {
    job = true;
    jobs.push_back(std::move(claimed));
  }
  void may_stop() override {}
  void hold_changed() override {}
  void left_job_filed(const EndedJob& ended) override { left.push_back(ended); }

  bool job = false, by_hand = false;
  std::vector<ClaimedJob> jobs;
  std::vector<EndedJob> left;
};

}  // namespace contourd::testing
