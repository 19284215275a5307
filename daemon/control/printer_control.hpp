// The methods by which an owner's programs control the printer. They know no transport: any front may call
// them. Event loop's thread only.
#pragma once

#include <string>
#include <string_view>

#include "daemon/control/control_method.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"

namespace contourd {

class PrinterControl {
 public:
  using Json = ControlMethod::Json;

  // All must outlive the control.
  PrinterControl(const PrinterContext& context, QueueHold& hold, CurrentJob& job, JobScheduler& scheduler,
                 const PrinterStatus& status)
      : context_(context), hold_(hold), job_(job), scheduler_(scheduler), status_(status) {}

  // All of them, by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

  // These return the status, and throw ControlRefusal.
  //
  // After the layer under way.
  Json pause();
  // The print, or the queue where that is held and nothing is printed.
  Json resume();
  Json cancel();
  // The owner has taken the part off: the queue goes on.
  Json plate_cleared();

 private:
  Json resume_queue();
  [[nodiscard]] bool has_unfinished_job() const;
  void require_print(std::string_view what) const;
  // Of a print that can be neither paused nor, when it is over, cancelled. REQUIRES: one that is not idle.
  [[nodiscard]] std::string why_it_ends() const;

  const PrinterContext& context_;
  QueueHold& hold_;
  CurrentJob& job_;
  JobScheduler& scheduler_;
  const PrinterStatus& status_;
};

}  // namespace contourd
