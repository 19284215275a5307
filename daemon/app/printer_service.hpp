// The printer service: wires the parts that take jobs from the spool one after the other, prepare, print and
// file them, and the control socket. Event loop's thread only.
//
// It has more members than other classes: each is one of the parts that it wires.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/app/service_stop.hpp"
#include "daemon/camera/camera.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/history_control.hpp"
#include "daemon/control/interrupted_control.hpp"
#include "daemon/control/log_control.hpp"
#include "daemon/control/manual_control.hpp"
#include "daemon/control/picture_control.hpp"
#include "daemon/control/preflight_control.hpp"
#include "daemon/control/printer_control.hpp"
#include "daemon/control/printer_metrics.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/control/queue_control.hpp"
#include "daemon/control/report_control.hpp"
#include "daemon/control/resin_control.hpp"
#include "daemon/control/screen_control.hpp"
#include "daemon/control/waiting_job_control.hpp"
#include "daemon/history/ended_job_notices.hpp"
#include "daemon/history/history_worker.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/history/reminders.hpp"
#include "daemon/history/vat.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/incoming_router.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class PrinterService final : private JobObserver, private QueueObserver, private PrinterUse {
 public:
  // All arguments must outlive the service.
  PrinterService(const PrinterConfig& config, EventLoop& loop, Clock& clock, Machine& machine, const Log& log,
                 Supervisor& supervisor);

  // Files interrupted prints and opens the spool and the socket; from then on jobs are taken. Throws
  // std::runtime_error.
  void start();

  // Ends the current print (light off, its files to failed/), takes no more jobs, and stops the loop when the
  // light is off and the print is filed, or after some seconds.
  void shut_down(const std::string& reason) { stop_.shut_down(reason); }

  // Takes no more jobs, and stops the loop when the current print is over and filed, so that a new program or
  // configuration can take over.
  void hand_over_when_idle() { stop_.hand_over_when_idle(); }

  // Reacts to an event that happened to the machine or is about to happen.
  void handle_event(const MachineEvent& event);

  // Calls `call` with true when a print or a manual operation begins, and with false when neither is running
  // any more. The same value may be passed several times.
  void on_printing(std::function<void(bool)> call) { printing_ = std::move(call); }

 private:
  void print_state_changed(const PrintState& state) override;
  void job_changed(const std::string& what) override;
  void resin_used(double ml) override;
  void job_ended(EndedJob job) override;
  void may_stop() override { stop_.try_to_stop(); }
  void hold_changed() override { scheduler_.hold_changed(); }

  void queue_changed() override {
    scheduler_.run();
    note_change();
  }
  void question_changed() override { notify("question", ControlServer::Delivery::Lossy); }
  void job_refused(EndedJob job) override;

  [[nodiscard]] bool has_job() const override { return job_.job() != nullptr; }
  [[nodiscard]] bool controlled_by_hand() const override { return manual_.in_use(); }
  void begin(ClaimedJob job) override;
  void left_job_filed(const EndedJob& job) override { notices_.add(job); }

  [[nodiscard]] ControlMethods control_methods();
  void manual_changed();
  // Lets the camera take a picture, if a layer of the print has been lifted or has risen.
  void look();
  // Warns if the analyzed print needs more resin than the vat holds.
  void compare_with_vat();
  // Returns the text of the service manager's status line.
  [[nodiscard]] std::string readiness() const;
  // Passes the jobs that the previous process left, and its last end, to the history.
  void adopt_left_jobs();
  // Queries the history for parts that are due to be replaced, and reports them.
  void remind();
  void part_replaced(WearPart part);
  // Records that the notice of this job's end needs no further attempt.
  void notice_sent(std::int64_t key);
  // Adds the job to the recent history and notifies all watching clients.
  void note_end(EndedJob job);
  void notify(const std::string& what, ControlServer::Delivery delivery);
  // Notifies all watching clients soon that a method, or the queue, has changed something. Changes in quick
  // succession are one notification.
  void note_change();

  PrinterContext context_;
  IncomingRouter incoming_router_;
  Spool spool_;
  JobReader reader_;
  QueueHold hold_;
  Vat vat_;
  PrintQueue queue_;
  HistoryWorker history_worker_;
  CurrentJob job_;
  SpoolClaims claims_;
  JobScheduler scheduler_;
  JobHistory history_;
  EndedJobNotices notices_;
  Camera camera_;
  ManualProcess manual_;
  ServiceStop stop_;
  Reminders reminders_;
  PrinterStatus status_;
  PrinterControl control_;
  QueueControl queue_control_;
  Worker picture_worker_;
  ManualControl manual_control_;
  HistoryControl history_control_;
  PreflightControl preflight_control_;
  ScreenControl screen_control_;
  InterruptedControl interrupted_control_;
  WaitingJobControl waiting_job_control_;
  ResinControl resin_control_;
  ReportControl report_control_;
  PictureControl picture_control_;
  LogControl log_control_;
  std::unique_ptr<ControlServer> server_;
  std::optional<MetricsFile> metrics_file_;
  std::uint64_t manual_operations_logged_ = 0;
  std::function<void(bool)> printing_;
  bool lifting_ = false;  // the plate moves up after a layer
  EventLoop::SourcePtr low_resin_timer_, change_timer_;
};

}  // namespace contourd
