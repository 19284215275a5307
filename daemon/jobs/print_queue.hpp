// The queue of the jobs in incoming/, in order of arrival or as a user has reordered them. Each job is read
// once while it waits, so that the user learns of a mistake while still nearby. If ask_before names findings,
// all layers of each job are analyzed too, and a job with such findings waits until a user accepts them. The
// next job is the first one that does not wait for confirmation. Event loop's thread only.
//
// It has many functions: one for each event that can concern a waiting job.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/history/job_history.hpp"
#include "daemon/jobs/job_checks.hpp"
#include "daemon/jobs/job_questions.hpp"
#include "daemon/jobs/queue_order.hpp"
#include "daemon/system/log.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct WaitingJob {
  std::string file;  // name in incoming/
  TimePoint arrived;
  enum class Check {
    Wanted,
    Running,
    Passed,
    Postponed,  // not enough free memory at the moment
    Refused,    // refused or removed; being moved to failed/
  } check = Check::Wanted;
  std::uint64_t check_number = 0;  // number of the running check or analysis
  enum class Analysis {
    Wanted,
    Running,
    Blocked,  // the resin profile cannot be used
    Done,
  } analysis = Analysis::Wanted;  // used only if ask_before names findings
  std::optional<AnalyzedJob> analyzed{};
  std::vector<std::string> asks{};  // findings that no user has accepted yet
  // Set while the job is being moved to failed/: its file disappeared (removed by a user or moved by the
  // spool), or a complete file arrived again.
  bool withdrawn = false, seen_again = false;
  std::string postponed{};  // why the check was postponed, already logged; else empty
  // True if it did not begin at once: the time to its first light then counts from the end of its wait.
  bool waited = false;
  std::string trouble{};                // why it cannot be claimed or analyzed, already logged
  std::optional<JobOutlook> outlook{};  // result of its check; nullopt before it, or if it found a mistake
  std::size_t taken_from = 0;           // place from which take_first() took it
  int interruptions = 0;                // checks and analyses that a rewrite interrupted

  // True while its check or analysis is running.
  [[nodiscard]] bool is_looked_at() const { return check == Check::Running || analysis == Analysis::Running; }
  // Discards the analysis, which is about other files or settings, and requests a new one.
  void analyze_again();
  // Requests a new check as well.
  void check_again();
};

// Observer of the queue.
class QueueObserver {
 public:
  virtual ~QueueObserver() = default;

  // Reports that something in the queue may be due now.
  virtual void queue_changed() = 0;
  // Reports that a job began or stopped waiting for confirmation.
  virtual void question_changed() = 0;
  // Reports that a job was refused, or removed by a user ("cancelled"), before its turn: it is in failed/, or
  // stays in incoming/ for good.
  virtual void job_refused(EndedJob job) = 0;
};

class PrintQueue {
 public:
  // All arguments must outlive the queue.
  PrintQueue(const PrinterConfig& config, JobChecks& checks, QueueObserver& observer, const Log& log)
      : log_(log),
        checks_(checks),
        observer_(observer),
        order_(checks, log),
        questions_(config, checks, log) {}

  // Number of places at the front of the queue within which jobs can be moved.
  static constexpr std::size_t kMaxInOrder = 1'000;

  // Restores the order that the last process saved. Must be called before any job arrives.
  void load_order(std::vector<std::string> files) { order_.load(std::move(files)); }

  // Adds incoming/`file`, which is complete. A file that was rewritten keeps its place and is checked again,
  // but moves to the end of the queue if it keeps interrupting its checks and analyses.
  void arrived(const std::string& file);
  // Removes incoming/`file`, which is gone, from the queue.
  void withdrawn(const std::string& file);

  // Starts the check of the first unchecked job. If there is none, starts the next analysis, if ask_before
  // names findings.
  void check_next();
  // Requests new checks of the jobs for which memory was short, and new analyses of the jobs whose profile
  // could not be used: both may have changed by now.
  void check_postponed();

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // All waiting jobs, in the order of the queue.
  [[nodiscard]] const std::deque<WaitingJob>& jobs() const { return jobs_; }
  // True if there is a next job: one that does not wait for confirmation.
  [[nodiscard]] bool has_first() const { return first() < jobs_.size(); }
  // Returns the place of the next job; jobs().size() if there is none.
  [[nodiscard]] std::size_t first() const;
  // Returns why the next job must not begin before its analysis; empty if it may. REQUIRES: has_first().
  [[nodiscard]] std::string first_unanalyzed() const;
  // False while the next job is being checked, or any refused job is being moved; the observer learns when
  // that ends. REQUIRES: has_first().
  [[nodiscard]] bool first_may_begin() const;

  // Returns the next job, to note that it does not begin at once, and why. REQUIRES: has_first().
  [[nodiscard]] WaitingJob& next();
  // Removes the next job from the queue and returns it. The saved order keeps its place until begun(),
  // withdrawn() or put_last(). REQUIRES: has_first().
  [[nodiscard]] WaitingJob take_first();
  // Notes that a job from take_first() begins. Its acceptances are kept until its end, see JobQuestions. The
  // new next job waits for this one.
  void begun(const WaitingJob& job);
  // Moves the next job to failed/ with this reason. REQUIRES: has_first().
  void refuse_first(const std::string& reason);

  // Puts a job that take_first() returned back at its place, so that it is the next job again, unless an
  // earlier job was accepted meanwhile.
  void put_first(WaitingJob job);
  // Puts a job that take_first() returned at the end of the queue.
  void put_last(WaitingJob job);

  [[nodiscard]] JobQuestions& questions() { return questions_; }
  [[nodiscard]] const JobQuestions& questions() const { return questions_; }
  // Accepts all findings for which the job waits; `who` is for the log. REQUIRES: the job is in the queue and
  // waits for confirmation.
  void accept(const std::string& file, const std::string& who);

  // Moves the job's files to failed/ with this reason, unless they are being rewritten. REQUIRES: the job is
  // in the queue, and not already on its way to failed/.
  void remove(const std::string& file, const std::string& reason);
  // Moves the job to the place `to`, counted from 0; to the end if there are fewer jobs. REQUIRES: the job is
  // in the queue; neither its place nor `to` is beyond kMaxInOrder.
  void move(const std::string& file, std::size_t to);

 private:
  using Position = std::deque<WaitingJob>::iterator;

  [[nodiscard]] Position find(const std::string& file);
  [[nodiscard]] JobChecks::Keep keep_for(const Position& job);
  void checked(const std::string& file, std::uint64_t number, const CheckedJob& found);
  void note_check(WaitingJob& job, const CheckedJob& found);
  void postpone(WaitingJob& job, const std::string& why);
  void analyze_next();
  void analyzed(const std::string& file, std::uint64_t number, const JobAnalysisOutcome& found);
  void note_analysis(WaitingJob& job, const JobAnalysisOutcome& found);
  void note_question(WaitingJob& job, const AnalyzedJob& analyzed);
  // A job that is being moved to failed/.
  struct Reject {
    std::string file;
    JobEnd end;
    bool removed = false;  // by a user
  };
  void reject(WaitingJob& job, const std::string& reason, bool removed = false);
  void rejected(const Reject& job, const FileRejections::Result& result);
  void not_rejected(const Position& job);
  void log_rejection(const Reject& job, const FileRejections::Result& result) const;
  void move_to_end(const Position& queued);
  void remove_withdrawn(const Position& job);

  const Log& log_;
  JobChecks& checks_;
  QueueObserver& observer_;
  std::deque<WaitingJob> jobs_;
  QueueOrder order_;
  JobQuestions questions_;
  int rejections_ = 0;  // number of rejections under way
  std::uint64_t checks_begun_ = 0;
};

// Returns the log fields of an entry about a file in incoming/.
[[nodiscard]] LogFields file_fields(const std::string& file);
// Logs that incoming/`file` is gone.
void log_withdrawn(const Log& log, const std::string& file);

}  // namespace contourd
