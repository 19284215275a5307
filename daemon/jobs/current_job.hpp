// The job under way, from its claim to its end: has it read, printed and analysed, writes down what happens
// to it, and has it filed. Event loop's thread only.
//
// It has many functions: each step of a job's way is one.
#pragma once

#include <future>
#include <optional>
#include <string>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/jobs/claimed_job.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/print_analyst.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/jobs/print_log.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/print_process.hpp"
#include "daemon/report/print_record.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

// Told what goes on, from inside the print process too, which must not be called back from there.
class JobObserver {
 public:
  JobObserver() = default;
  JobObserver(const JobObserver&) = delete;
  JobObserver& operator=(const JobObserver&) = delete;
  virtual ~JobObserver() = default;

  // Before anything is done about it.
  virtual void print_state_changed(PrintState state) = 0;
  // What a client may want to know: "state", "layer" or "analysis".
  virtual void job_changed(const std::string& what) = 0;
  // The light, which may have been on up to now, is confirmed off; or the print ends without that.
  virtual void light_gone() = 0;
  // A print's memory was given back.
  virtual void memory_freed() = 0;
  // The print is over and is filed next, which waits a moment for what is returned. Sets the job's times.
  virtual std::shared_future<void> print_over(EndedJob& job) = 0;
  // There is no job any more; another may begin.
  virtual void job_ended(EndedJob job) = 0;
  // A stop may have nothing more to wait for.
  virtual void may_stop() = 0;
};

class CurrentJob final : private PrintObserver {
 public:
  struct State {
    explicit State(ClaimedJob job) : claimed(std::move(job)) {}

    ClaimedJob claimed;
    std::optional<PreparedJob> prepared;    // nothing while it is being read; its plan moves to the process
    std::optional<PrintRecord> record;      // nothing before its print begins
    std::optional<PrintFindings> findings;  // nothing while the analysis is under way
    nlohmann::ordered_json analysis;        // these in short; null while there are none
    std::optional<EndedPrint> over;         // once the print is, until its analysis is too
    EndedJob ended;                         // once it is being filed
    bool cancel_wanted = false;             // cancelled before it could start
    int readings = 0;                       // that found no room in memory
  };

  // All must outlive the job.
  CurrentJob(const PrinterContext& context, Spool& spool, JobReader& reader, QueueHold& hold,
             JobObserver& observer);

  // REQUIRES: there is none.
  void begin(ClaimedJob job);
  // Cancels its print, which is not over, or has none begin. REQUIRES: a job.
  void cancel();
  // Ends a print under way: light off, its files to failed/. A job that is being read does not begin.
  void stop(const std::string& reason);
  // Back to incoming/. REQUIRES: a job that has not begun.
  void give_back();
  // Has the print filed that is over, and whose analysis is not. Does nothing when there is none.
  void stop_analysis();
  // The longest turn of the loop with light goes into the report.
  void add_lit_turn(const EventLoop::Turn& turn);

  // What its print has used so far. REQUIRES: a print under way.
  [[nodiscard]] JobFigures figures() const;

  // Nothing when there is none.
  [[nodiscard]] const State* job() const { return job_ ? &*job_ : nullptr; }
  // REQUIRES: a job.
  [[nodiscard]] const std::string& name() const {
    expects(job_.has_value(), "there is a job");
    return job_->claimed.files.name;
  }
  // Its print is over, it is not filed yet.
  [[nodiscard]] bool finishing() const;
  // The archivist is at it.
  [[nodiscard]] bool is_being_filed() const { return archivist_.busy(); }
  [[nodiscard]] PrintProcess& print() { return process_; }
  [[nodiscard]] const PrintProcess& print() const { return process_; }

 private:
  void state_changed(PrintState state) override;
  void layer_done(const LayerRecord& layer) override;
  void interrupted(const std::string& what) override;
  void light_gone() override;
  void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) override;

  void read();
  void give_up_reading();
  // Whether it is read again, as there was no room in memory that there may be soon.
  [[nodiscard]] bool read_later(const JobRefusal& refusal);
  void was_read(ReadJob result);
  // Has it in failed/.
  void refuse(const std::string& outcome, const std::string& reason);
  void start_print();
  void analyzed(AnalyzedPrint print);
  void file();
  void filed(const FiledPrint& print);

  const PrinterContext& context_;
  Spool& spool_;
  JobReader& reader_;
  QueueHold& hold_;
  JobObserver& observer_;
  PrintLog log_;
  PrintProcess process_;
  PrintAnalyst analyst_;
  PrintArchivist archivist_;
  std::optional<State> job_;
  bool stopping_ = false;
  EventLoop::SourcePtr read_timer_;
};

}  // namespace contourd
