// The jobs in incoming/ that wait for their turn, in the order of their arrival or of their owner. Each is
// read once while it waits, so that its owner hears of a mistake while still there. Where the printer's owner
// wants to be asked about findings, each is looked through as well, and waits for its owner's word when it
// has some. The next job is the first that does not wait for that. Event loop's thread only.
//
// It has many functions: each thing that may happen to a job that waits is one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/jobs/job_questions.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/queue_order.hpp"
#include "daemon/prepare/job_settings.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct WaitingJob {
  std::string file;  // in incoming/
  TimePoint arrived;
  enum class Check {
    Wanted,
    Running,
    Passed,
    Postponed,  // there is no room for it in memory beside what is there now
    Refused,    // on its way to failed/, or removed and on its way there
  } check = Check::Wanted;
  std::uint64_t check_number = 0;  // of the one that is running, or of the analysis
  enum class Analysis {
    Wanted,
    Running,
    Blocked,  // the resin's profile cannot be used
    Done,
  } analysis = Analysis::Wanted;  // where the printer's owner is to be asked
  std::optional<AnalyzedJob> analyzed{};
  std::vector<std::string> asks{};  // findings that its owner has not accepted
  // On its way to failed/ it went, by the owner's hand or by the spool's; or was seen to be whole again.
  bool withdrawn = false, seen_again = false;
  std::string postponed{};              // why, already told; empty when it was not
  bool waited = false;                  // for another print, or for the plate
  std::string trouble{};                // why it could not be claimed, already told
  std::optional<JobOutlook> outlook{};  // what its check found; nothing before, and when that found a mistake
  std::size_t taken_from = 0;           // its place when take_first() gave it
  int interruptions = 0;                // of a look at it, since it was written again

  // For its check, or through its layers.
  [[nodiscard]] bool is_looked_at() const { return check == Check::Running || analysis == Analysis::Running; }
  // What was found is about other files or settings.
  void analyze_again();
  // What its check has found, too.
  void check_again();
};

class PrintQueue {
 public:
  struct Calls {
    // Reads incoming/`file`, and calls `done` from the loop: see JobReader::check(). Of the next job, what
    // was prepared is to be kept.
    std::function<void(const std::string& file, JobReader::Keep keep,
                       std::function<void(const CheckedJob&)> done)>
        check;
    // What was kept of incoming/`file` is not wanted any more.
    std::function<void(const std::string& file)> forget;
    // Files it with its reason, and calls `done` from the loop: see Spool::reject().
    std::function<void(const std::string& file, const std::string& reason, Spool::Rejected done)> reject;
    // Something in the queue may be due now.
    std::function<void()> changed;
    // A job was refused: it is in failed/, or lies where it is for good.
    std::function<void(const std::string& file, const std::string& reason)> refused;
    // The same of one that its owner has removed.
    std::function<void(const std::string& file, const std::string& reason)> removed;
    QueueOrder::Keep keep_order;
    JobQuestions::Calls questions{};
  };
  // The log must outlive the queue.
  PrintQueue(const Log& log, Calls calls);

  // So many of the first may be moved, and no job behind them.
  static constexpr std::size_t kMostInOrder = 1'000;

  // The order that the last process has left. Before anything arrives.
  void load_order(std::vector<std::string> files) { order_.load(std::move(files)); }

  // incoming/`file` is whole. Written again, it keeps its place and is checked again; behind all others when
  // that interrupts look after look at it.
  void arrived(const std::string& file);
  // incoming/`file` is gone.
  void withdrawn(const std::string& file);

  // Has the first one checked that has not been, if there is one; else has one looked through, if that is
  // wanted.
  void check_next();
  // Those have their check again for which there was no room: some memory may be free by now.
  void check_postponed();

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // The next one first.
  [[nodiscard]] const std::deque<WaitingJob>& jobs() const { return jobs_; }
  // Whether there is a next job: one that does not wait for its owner's word.
  [[nodiscard]] bool has_first() const { return first() < jobs_.size(); }
  // The place of the next job; jobs().size() when there is none.
  [[nodiscard]] std::size_t first() const;
  // Why it is not to begin before it is looked through; empty when it may. REQUIRES: has_first().
  [[nodiscard]] std::string first_unanalyzed() const;
  // False while its check is being made, or a refused file looks for a name: changed() comes then. REQUIRES:
  // has_first().
  [[nodiscard]] bool first_may_begin() const;

  // It does not begin at once: the time until its first light counts from the end of its wait. REQUIRES:
  // has_first().
  void keep_first_waiting() {
    expects(has_first(), "a job waits");
    jobs_[first()].waited = true;
  }
  // It keeps its place until claimed() or put_last(). REQUIRES: has_first().
  [[nodiscard]] WaitingJob take_first();
  // What take_first() gave will not come back.
  void claimed(const std::string& file) { order_.remove(file); }
  // REQUIRES: has_first().
  void refuse_first(const std::string& reason);

  // What take_first() gave is the next job again, unless its owner's word has come for one before it.
  void put_first(WaitingJob job);
  void put_last(WaitingJob job);

  [[nodiscard]] JobQuestions& questions() { return questions_; }
  [[nodiscard]] const JobQuestions& questions() const { return questions_; }
  // Its owner accepts what is asked about it; `who` is for the log. REQUIRES: there is that job, and it asks.
  void accept(const std::string& file, const std::string& who);

  // Its files go to failed/ with this reason, unless somebody is writing them anew. REQUIRES: there is that
  // job, and it is not on its way there.
  void remove(const std::string& file, const std::string& reason);
  // To that place, from 0; the last one when there are fewer. REQUIRES: there is that job; neither its place
  // nor that one is beyond kMostInOrder.
  void move(const std::string& file, std::size_t to);

 private:
  enum class Leaving { Refused, Removed };

  using Position = std::deque<WaitingJob>::iterator;

  [[nodiscard]] Position find(const std::string& file);
  void checked(const std::string& file, std::uint64_t number, const CheckedJob& found);
  void note_check(WaitingJob& job, const CheckedJob& found);
  void postpone(WaitingJob& job, const std::string& why);
  void analyze_next();
  void analyzed(const std::string& file, std::uint64_t number, const JobAnalysisOutcome& found);
  void note_analysis(WaitingJob& job, const JobAnalysisOutcome& found);
  void note_question(WaitingJob& job, const AnalyzedJob& analyzed);
  void leave(WaitingJob& job, const std::string& reason, Leaving how);
  struct Reject {
    std::string file, reason;
    Leaving how;
  };
  void rejected(const Reject& job, Spool::Rejection rejection, const std::string& trouble);
  void not_rejected(const Position& job);
  void tell_rejected(const Reject& job, Spool::Rejection rejection, const std::string& trouble) const;
  void move_behind_others(const Position& queued);
  void remove_withdrawn(const Position& job);

  const Log& log_;
  Calls calls_;
  std::deque<WaitingJob> jobs_;
  QueueOrder order_;
  JobQuestions questions_;
  int rejections_ = 0;  // under way
  std::uint64_t checks_begun_ = 0;
};

// Those of an entry about a file in incoming/.
[[nodiscard]] LogFields file_fields(const std::string& file);
void tell_withdrawn(const Log& log, const std::string& file);

}  // namespace contourd
