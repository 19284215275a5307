// Decides when the queue goes on: has the waiting jobs checked while something is in their way, and claims
// the next one when nothing is: moves it to printing/, or copies what cannot be moved. Event loop's thread
// only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <system_error>

#include "daemon/jobs/claimed_job.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class JobScheduler {
 public:
  struct Calls {
    std::function<bool()> has_job;  // whether one is claimed and not filed yet
    std::function<bool()> prints;   // or there may be light otherwise: the disk is not waited for
    std::function<bool()> controlled_by_hand;
    std::function<void(ClaimedJob)> begin;
    std::function<void()> copy_over;  // copying() has become false
  };
  // All must outlive the scheduler.
  JobScheduler(const PrinterContext& context, Spool& spool, PrintQueue& queue, QueueHold& hold, Calls calls);

  // Does what is due: keeps the hold's records, begins the next job, or has a waiting one checked. Never from
  // inside the print process.
  void run();
  // From anywhere.
  void run_soon();
  // No job begins any more.
  void stop() { stopped_ = true; }

  // Why the next job does not begin; empty when it does, or there is none.
  [[nodiscard]] const std::string& waiting_for() const { return waiting_for_; }
  // A job is being copied to printing/.
  [[nodiscard]] bool copying() const { return copying_.has_value(); }

 private:
  // In no list while it is copied.
  struct CopiedJob {
    WaitingJob job;
    std::optional<JobSettings> settings;
  };

  void run_later(Duration wait);
  void retry_later(Duration wait);
  void take_what_is_due();
  [[nodiscard]] std::string reason_to_wait() const;
  [[nodiscard]] bool waits_for_profile() const;
  void claim_next();
  // Its owner may have to be asked about what cannot be held: known only when it is prepared.
  [[nodiscard]] bool is_checked_first(const CopiedJob& claimed) const;
  // Throws ProfileTrouble when the queue has to wait for the profile.
  [[nodiscard]] std::optional<JobSettings> settings_of(const WaitingJob& job) const;
  void wait_for_profile(WaitingJob job, const std::string& why);
  void not_claimed(CopiedJob claimed, const std::system_error& error);
  // It is in the log once; the job goes back to the queue and waits.
  void note_trouble(WaitingJob& job, const std::string& trouble);
  void copy(CopiedJob job, const std::string& why);
  void copied(const Spool::Copy& copy, const std::string& why);
  void not_copied(WaitingJob job, const std::string& trouble);
  void begin(CopiedJob claimed, const JobFiles& files);

  const PrinterContext& context_;
  Spool& spool_;
  PrintQueue& queue_;
  QueueHold& hold_;
  Calls calls_;
  std::string waiting_for_;  // told already
  std::optional<CopiedJob> copying_;
  bool stopped_ = false;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
