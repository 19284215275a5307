// The methods status, pause, resume, cancel and plate_cleared of the control socket. The methods for the
// queue, manual control, the history and the screen have classes of their own; PrinterService merges all of
// them. Independent of the transport. Event loop's thread only.
#pragma once

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

  // All arguments must outlive the control.
  PrinterControl(const PrinterContext& context, QueueHold& hold, CurrentJob& job, JobScheduler& scheduler,
                 const PrinterStatus& status)
      : context_(context), hold_(hold), job_(job), scheduler_(scheduler), status_(status) {}

  // Returns these methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

  // The following methods return the status, and throw ControlRefusal.
  //
  // Pauses the print after the current layer, or at the point that the parameters name.
  Json pause(const Json& parameters);
  // Changes a setting of the print from the next layer on, or of its rises from now on. Calls `later` with
  // the status, or a refusal.
  void set(const Json& parameters, ControlMethod::Later later);
  // Returns the settings of the print that can be changed: what is in force now, and the bounds.
  [[nodiscard]] Json settings() const;
  // Leaves a copy dark from the next layer on.
  Json exclude(const Json& parameters);
  // Returns the copies on the plate.
  [[nodiscard]] Json copies() const;
  // Resumes the print, or the queue if it is held and nothing prints.
  void resume(ControlMethod::Later later);
  // Cancels the current job.
  Json cancel();
  // Notes that the user has removed the part, and lets the queue go on.
  // Calls `later` when the record of the occupied plate is removed from the disk.
  void plate_cleared(ControlMethod::Later later);

 private:
  Json resume_queue();
  // Throws ControlRefusal unless the print can be resumed now.
  void require_resumable() const;
  [[nodiscard]] bool has_unfinished_job() const;
  [[nodiscard]] PausePoint pause_point(const Json& parameters) const;
  // Returns the layer from which on a change holds, from 0; throws ControlRefusal if no layer follows.
  [[nodiscard]] std::int32_t next_layer() const;
  // Returns, in a sentence, why a setting cannot be changed now; empty if it can.
  [[nodiscard]] std::string why_not_changed(std::string_view setting) const;
  // Returns the bounds of a setting for a change that is made now. REQUIRES: it can be changed.
  [[nodiscard]] Limits<double> bounds_of(std::string_view setting) const;
  // Sets a setting of the rises, one of kPrintSettings.
  void set_rises(std::string_view setting, double value, ControlMethod::Later later);
  void require_print(std::string_view what) const;
  void require_ready(std::string_view what) const;

  const PrinterContext& context_;
  QueueHold& hold_;
  CurrentJob& job_;
  JobScheduler& scheduler_;
  const PrinterStatus& status_;
};

}  // namespace contourd
