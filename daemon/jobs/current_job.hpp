// The current job, from its claim to its end: has it read, printed and analyzed, records what happens to it,
// also in the history, and has it filed. Event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "core/contract/expects.hpp"
#include "daemon/frames/frame_log.hpp"
#include "daemon/history/history_worker.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/print_analyst.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/jobs/print_log.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/printer_use.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/print_mode.hpp"
#include "daemon/progress/progress_keeper.hpp"
#include "daemon/report/print_record.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

// Observer of the current job. Its functions are also called from inside the print mode, which must not be
// called back from there.
class JobObserver {
 public:
  virtual ~JobObserver() = default;

  // Reports a new state of the print, before anything else is done about it.
  virtual void print_state_changed(const PrintState& state) = 0;
  // Reports a change that a client may want to know: "state", "layer" or "analysis".
  virtual void job_changed(const std::string& what) = 0;
  // Reports that a layer has cured this much resin.
  virtual void resin_used(double /*ml*/) {}
  // Reports that the job has ended, its memory is freed, and another may begin.
  virtual void job_ended(EndedJob job) = 0;
  // Reports that a stop of contourd may have nothing more to wait for.
  virtual void may_stop() = 0;
};

class CurrentJob final : private PrintObserver {
 public:
  struct State {
    explicit State(ClaimedJob job) : claimed(std::move(job)) {}

    ClaimedJob claimed;
    std::int64_t key = 0;                 // in the history (EndedJob)
    std::optional<PreparedJob> prepared;  // nullopt while it is being read; its plan moves to the print mode
    std::optional<PrintRecord> record;    // nullopt before its print begins
    PrintForecast forecast;               // of its print, made when the print begins
    std::optional<PrintFindings> findings;      // nullopt while the analysis is under way
    nlohmann::ordered_json analysis;            // the findings in short; null while there are none
    std::optional<EndedPrint> over;             // set when the print is over, until its analysis is too
    EndedJob ended;                             // set once the job is being filed
    bool cancel_wanted = false;                 // cancelled before it could start
    std::optional<std::string> plate_before;    // the plate's occupant before this job
    bool leaving = false;                       // it does not begin, and its files are being moved
    bool had_light = false;                     // the light of its first layer was due
    int readings = 0;                           // number of readings that found too little memory
    bool plans_rises = false;                   // set_rises() is under way
    std::vector<std::string> warnings;          // about the print under way, a sentence each
    std::optional<RiseSettings> rise_settings;  // of the print that a power cut ended, until it goes on
  };

  // All arguments must outlive this object.
  CurrentJob(const PrinterContext& context, Spool& spool, JobReader& reader, QueueHold& hold,
             HistoryWorker& history, JobObserver& observer);
  ~CurrentJob() override;

  // Reads the job, then prints it. REQUIRES: there is no current job.
  void begin(ClaimedJob job);
  // Changes a setting of the print from the next layer on, and records this. REQUIRES: a print under way, one
  // of kPrintSettings that is not of rises, and room in its record.
  void set(std::string_view setting, double value);
  // Plans the rises that are left with other settings, on a thread of its own, then changes them and records
  // this. Calls `done` once, from the loop, with the reason why nothing has changed, or an empty text.
  // REQUIRES: a print with rises_ahead(), and room in its record for three changes.
  void set_rises(const RiseSettings& settings, std::function<void(const std::string& refusal)> done);
  // Leaves a copy dark from the next layer on, and records this. `number` is its place in copies_of(), from
  // 0. REQUIRES: a print under way, and such a copy.
  void exclude(std::size_t number);
  // See ProgressKeeper.
  void leave_pause(ProgressKeeper::Left left) { progress_.leave_pause(std::move(left)); }
  // Cancels its print, which must not be over, or prevents it from beginning. REQUIRES: a job.
  void cancel();
  // Ends a print under way: turns the light off and moves its files to failed/. Prevents the print of a job
  // that is being read.
  void stop(const std::string& reason);
  // Moves the job back to incoming/, while is_being_filed(); then there is no job. A job that a power cut
  // ended stays in printing/. REQUIRES: a job that has not begun.
  void give_back();
  // Files a print that is over and waits only for its analysis. Does nothing if there is none.
  void stop_analysis();

  // Returns the current job; nullptr if there is none.
  [[nodiscard]] const State* job() const { return job_ ? &*job_ : nullptr; }
  // Returns the job's name. REQUIRES: a job.
  [[nodiscard]] const std::string& name() const {
    expects(job_.has_value(), "there is a job");
    return job_->claimed.files.name;
  }
  // True if its print is over and not filed yet.
  [[nodiscard]] bool finishing() const;
  // Returns an upper bound of the light in all prints so far.
  [[nodiscard]] Duration lit() const { return lit_; }
  // True while its files are moved out of printing/.
  [[nodiscard]] bool is_being_filed() const { return archivist_.busy() || (job_ && job_->leaving); }
  [[nodiscard]] PrintMode& print() { return *print_; }
  [[nodiscard]] const PrintMode& print() const { return *print_; }

 private:
  void light_due() override;
  void state_changed(const PrintState& state) override;
  void layer_done(const LayerRecord& layer) override;
  void layer_peeled(std::int32_t layer, const PeelRecord& peel) override { job_->record->add(layer, peel); }
  void warned(const std::string& what) override;
  void frame_over(const FrameRecord& frame) override { frames_.add(frame); }
  void progressed(const PrintProgress& print) override { progress_.keep(print); }
  void interrupted(const std::string& what) override;
  void light_gone() override;
  void print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) override;

  // Adds a turn of the loop during which the light was on; the report contains the longest.
  void add_lit_turn(const EventLoop::Turn& turn);
  void read();
  void was_read(ReadJob result);
  void wait_again(const std::string& reason);
  [[nodiscard]] std::string why_not_continued() const;
  // Moves the job to failed/, then reports its end; but a print that a power cut ended waits for the user
  // again.
  void refuse(PrintOutcome outcome, const std::string& reason);
  void given_back(const std::string& trouble);
  void refusal_filed(const JobEnd& end, const std::string& why_it_stays);
  [[nodiscard]] JobEnd end_as(PrintOutcome outcome, const std::string& reason) const;
  void occupy_plate();
  void plate_saved(const std::string& trouble);
  void start_print();
  void record_progress();
  void take_changes(const JobProgress::Changes& changes);
  void record_changes();
  void record_change(std::string_view setting, double value, std::optional<Nanometers> height);
  void rises_planned(const RisesAhead& planned, const std::variant<ChangedRises, std::string>& result,
                     const std::function<void(const std::string& refusal)>& done);
  void go_on();
  void analyzed(AnalyzedPrint print);
  void file();
  void filed(const FiledPrint& print);

  const PrinterContext& context_;
  Spool& spool_;
  JobReader& reader_;
  QueueHold& hold_;
  HistoryWorker& history_;
  JobObserver& observer_;
  PrintLog log_;
  std::unique_ptr<PrintMode> print_;
  PrintAnalyst analyst_;
  PrintArchivist archivist_;
  ProgressKeeper progress_;
  FrameLog frames_;
  Worker speeds_;
  std::optional<State> job_;
  Duration lit_{};
  bool stopping_ = false;
  EventLoop::SourcePtr read_timer_;
};

}  // namespace contourd
