// Decides when the next job begins. While something prevents that, has waiting jobs checked; otherwise claims
// the next job: moves its files to printing/, or copies them if they cannot be moved. Event loop's thread
// only.
#pragma once

#include <optional>
#include <string>

#include "daemon/jobs/job_claims.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/printer_use.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class JobScheduler {
 public:
  // All must outlive the scheduler.
  JobScheduler(const PrinterContext& context, Spool& spool, JobClaims& claims, PrintQueue& queue,
               QueueHold& hold, PrinterUse& use)
      : context_(context), spool_(spool), claims_(claims), queue_(queue), hold_(hold), use_(use) {}

  // Does what is due: saves the hold's records again if the disk refused them, begins the next job, or starts
  // the check of a waiting one. Must not be called from inside the print process.
  void run();
  // Schedules run(). May also be called from inside the print process.
  void run_soon();
  // Schedules run(), after a change of the hold or an attempt to save it.
  void hold_changed();
  // Prevents any further job from beginning.
  void stop() { stopped_ = true; }

  // Returns why the next job does not begin; empty if it begins, or if there is none.
  [[nodiscard]] const std::string& waiting_for() const { return waiting_for_; }
  // True while a job is being moved or copied to printing/.
  [[nodiscard]] bool claiming() const { return claiming_.has_value(); }

 private:
  // A job taken from the queue. While its files are moved or copied, no other list contains it.
  struct TakenJob {
    WaitingJob job;
    std::optional<JobSettings> settings;
  };

  void run_later(Duration wait);
  void retry_later(Duration wait);
  void take_what_is_due();
  // Returns why no job begins, as far as that is known without the disk; empty if there is no reason.
  [[nodiscard]] std::string reason_to_wait() const;
  // Has waiting jobs checked while the next one waits for this reason; empty if it waits for the end of a
  // job.
  void wait_because(const std::string& reason);
  [[nodiscard]] bool waits_for_profile() const;
  void look_at_next();
  void looked_at(const WaitingJob& before, const JobLook& look);
  void claim_next(const JobLook& look);
  // Returns why the queue has to wait for the job's resin profile; empty if it does not.
  [[nodiscard]] static std::string trouble_of_profile(const WaitingJob& job, const JobLook& look);
  void wait_for_profile(WaitingJob& job, const std::string& why);
  void claimed(const Claim& claim);
  void not_claimed(const Claim& claim);
  // Logs `trouble` once, and marks the job as waiting.
  void note_trouble(WaitingJob& job, const std::string& trouble);
  void copied(const Spool::Copy& copy, const std::string& why);
  void not_copied(WaitingJob job, const std::string& trouble);
  void begin(TakenJob taken, const JobFiles& files);

  const PrinterContext& context_;
  Spool& spool_;
  JobClaims& claims_;
  PrintQueue& queue_;
  QueueHold& hold_;
  PrinterUse& use_;
  std::string waiting_for_;   // already logged
  std::string look_trouble_;  // found by the last look at the next job
  bool looking_ = false;      // a look at the next job is under way
  std::optional<TakenJob> claiming_;
  bool stopped_ = false, hold_just_changed_ = false;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
