// What holds the queue until the owner acts: the queue is held, the plate holds a part, a job in printing/ is
// not filed. All of it survives a restart: the spool's records are kept on the disk, and they are there
// before what they tell of can be forgotten. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/unfiled_jobs.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class QueueHold {
 public:
  struct Calls {
    // While there may be light, the disk is not waited for: what is to be recorded is due when it is dark.
    std::function<bool()> light_may_be_on;
    // Some time after the disk did not take the records. To come back to keep_due().
    std::function<void()> retry;
    // A job is filed that the last process did not file.
    std::function<void(const EndedJob&)> filed{};
  };
  // Context and spool must outlive the hold.
  QueueHold(const PrinterContext& context, Spool& spool, Calls calls);

  // Takes over what the last process recorded.
  void load();
  struct LeftJob {
    std::string name;
    PrintEnd end;
  };
  // Takes over the jobs that the last process left in printing/: one that did not end holds the queue and has
  // its part on the plate. `ended_in_reading` says of a job that had not begun whether reading it ended that
  // process. Returns them with their ends.
  std::vector<LeftJob> adopt_left_jobs(const std::function<bool(const JobFiles&)>& ended_in_reading);

  // No job begins from now on until release(), whatever the plate holds. The first reason stays.
  void hold(const std::string& why);
  void release();
  // Why it is held; nothing when it is not.
  [[nodiscard]] const std::optional<std::string>& reason() const { return reason_; }
  // That it is held, why, and what the owner is to do; empty when it is not.
  [[nodiscard]] std::string sentence() const;

  // The job whose part is on the plate; nothing when the plate is clear.
  [[nodiscard]] const std::optional<std::string>& plate_occupant() const { return plate_occupant_; }
  // Has it on the disk at once. Throws std::system_error.
  void set_plate_occupant(const std::optional<std::string>& job);

  // A job that could not be moved out of printing/. No other begins before it is.
  void add_unfiled(const JobFiles& files, const PrintEnd& end);

  // Why no job is to begin: the hold before the unfiled job before the plate; empty when one may.
  [[nodiscard]] std::string reason_to_wait() const;

  // Has the disk know all this for the next start, then files what is not filed. What it does not take now is
  // tried again.
  void keep();
  // Whether keep() waits for the dark.
  [[nodiscard]] bool due() const { return due_; }
  // Whether there is something that the disk did not take.
  [[nodiscard]] bool failed() const { return !trouble_.empty(); }

 private:
  // Returns how it ended.
  PrintEnd adopt(const JobFiles& files, const std::optional<PrintEnd>& end);
  void try_to_keep();

  const PrinterContext& context_;
  Spool& spool_;
  Calls calls_;
  UnfiledJobs unfiled_;
  std::optional<std::string> reason_, plate_occupant_;
  std::string trouble_;  // why the disk does not know all of these; empty when it does
  bool due_ = false;
  EventLoop::SourcePtr retry_timer_;
};

}  // namespace contourd
