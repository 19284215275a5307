// The reasons for which the queue waits until a user acts: the queue is held, the plate holds a part, or a
// job in printing/ is not filed. They survive a restart: the spool's records are on the disk before the
// files from which they could be derived leave printing/. Event loop's thread only; the disk is written by
// the spool's thread.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/unfiled_jobs.hpp"
#include "daemon/progress/interrupted_print.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class QueueHold {
 public:
  // All must outlive the hold.
  QueueHold(const PrinterContext& context, Spool& spool, PrinterUse& use)
      : context_(context), spool_(spool), use_(use), unfiled_(context.log, use) {}

  // Restores what the last process recorded.
  void load();
  // Takes over the jobs that the last process left in printing/, records the ends of those that have none,
  // and files them. Blocks until the disk has done that, so that it is called before the event loop runs. A
  // print that did not end holds the queue, and its part is on the plate. If the progress record tells how
  // far it was, its job waits in printing/ until the user decides: see interrupted(). `ended_in_reading`
  // returns true for a job that had not begun and whose reading ended that process.
  void adopt_left_jobs(const std::function<bool(const JobFiles&)>& ended_in_reading);

  // Returns the print that waits for the user's decision; nullopt if there is none. Its end is recorded and
  // reported already.
  [[nodiscard]] const std::optional<InterruptedPrint>& interrupted() const { return interrupted_; }
  // Files the interrupted print, which the user gives up. Does nothing if there is none.
  void give_up_interrupted();
  // Records that the plate of the interrupted print is moved by hand by this distance, or by an unknown one,
  // so that the print does not go on. Does nothing if there is none.
  void interrupted_moves(std::optional<Nanometers> distance);
  // Forgets the interrupted print, which goes on (nullopt), or takes it back, because it could not go on. The
  // queue stays held until release().
  void set_interrupted(std::optional<InterruptedPrint> print) { interrupted_ = std::move(print); }
  // True if the queue is held because a print was interrupted whose part may hang on the plate, and no
  // setting of the printer keeps the next job from it: only a user who has cleared the plate may release the
  // queue.
  [[nodiscard]] bool part_may_hang() const;

  // Lets no job begin until release(), even if the plate is clear. If the queue is held already, the first
  // reason stays.
  void hold(const std::string& why);
  void release();
  // Returns why the queue is held; nullopt if it is not.
  [[nodiscard]] const std::optional<std::string>& reason() const { return reason_; }
  // Returns a sentence with the reason and with what the user has to do; empty if the queue is not held.
  [[nodiscard]] std::string sentence() const;

  // Returns the job whose part is on the plate; nullopt if the plate is clear.
  [[nodiscard]] const std::optional<std::string>& plate_occupant() const { return plate_occupant_; }
  // Receives the disk's error, or an empty text if the disk has the records. Called from the loop.
  using Saved = std::function<void(const std::string& trouble)>;
  // Returns at once, and calls `saved` when the disk has the record, or has refused it.
  void set_plate_occupant(const std::optional<std::string>& job, Saved saved = nullptr);

  // Adds a job that could not be moved out of printing/. No other job begins before it is moved.
  void add_unfiled(const JobFiles& files, const JobEnd& end);

  // Returns why no job may begin: the hold, else an unfiled job, else the plate; empty if one may.
  [[nodiscard]] std::string reason_to_wait() const;

  // Tries again what the disk did not accept, unless an attempt is under way.
  void retry();
  // True if the last attempt to save or file something failed.
  [[nodiscard]] bool failed() const { return !trouble_.empty(); }
  // True while the spool's thread saves or files something.
  [[nodiscard]] bool saving() const { return attempts_ > 0; }
  // Returns the end of the last attempt so far; invalid if there was none.
  [[nodiscard]] std::shared_future<void> last_attempt() const { return last_attempt_; }

 private:
  // Takes over one job from printing/.
  void adopt(const JobFiles& files, bool ended_in_reading);
  // Keeps an interrupted print for the user's decision; false if the record does not tell how far it was.
  bool await_decision(const JobFiles& files, JobEnd& end);
  // Returns the recorded end of a job in printing/, or records that it has none.
  [[nodiscard]] JobEnd end_of_left(const std::string& job, bool ended_in_reading);
  // Saves the records for the next start, then files the unfiled jobs.
  void keep(Saved saved = nullptr);
  // Does the same on this thread, before the event loop runs.
  void keep_now();
  void kept(const JobFilingRun& filing, const std::string& trouble);

  const PrinterContext& context_;
  Spool& spool_;
  PrinterUse& use_;
  UnfiledJobs unfiled_;
  std::optional<std::string> reason_, plate_occupant_;
  ProgressRecord::Found progress_;  // as the last process left it
  std::optional<InterruptedPrint> interrupted_;
  bool without_files_ = false;  // the record of a print stays although its files are gone
  std::string trouble_;         // why saving or filing failed; empty if all is on the disk
  int attempts_ = 0;            // under way
  std::shared_future<void> last_attempt_;
};

}  // namespace contourd
