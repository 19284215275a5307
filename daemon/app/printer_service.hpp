// The printer service: wires the parts that take jobs from the spool one after the other, prepare, print and
// file them, and the control socket. Event loop's thread only.
//
// It has more members than other classes: each is one of the parts that it wires.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "daemon/control/control_server.hpp"
#include "daemon/control/history_control.hpp"
#include "daemon/control/manual_control.hpp"
#include "daemon/control/printer_control.hpp"
#include "daemon/control/printer_metrics.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/control/queue_control.hpp"
#include "daemon/control/screen_control.hpp"
#include "daemon/history/ended_job_notices.hpp"
#include "daemon/history/history_worker.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/history/reminders.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/incoming_router.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class PrinterService final : private JobObserver {
 public:
  // All arguments must outlive the service.
  PrinterService(const PrinterConfig& config, EventLoop& loop, Clock& clock, Machine& machine, const Log& log,
                 Supervisor& supervisor);
  ~PrinterService() override;

  // Files interrupted prints and opens the spool and the socket; from then on jobs are taken. Throws
  // std::runtime_error.
  void start();

  // Ends the current print (light off, its files to failed/), takes no more jobs, and stops the loop when the
  // light is off and the print is filed, or after some seconds.
  void shut_down(const std::string& reason);

  // Takes no more jobs, and stops the loop when the current print is over and filed, so that a new program or
  // configuration can take over.
  void hand_over_when_idle();

  // Reacts to an event that happened to the machine or is about to happen.
  void handle_event(const MachineEvent& event);

  // Calls `call` with true when a print or a manual operation begins, and with false when neither is running
  // any more. The same value may be passed several times.
  void on_printing(std::function<void(bool)> call) { printing_ = std::move(call); }

 private:
  enum class Ending { No, HandOver, ShutDown };

  void print_state_changed(const PrintState& state) override;
  void job_changed(const std::string& what) override;
  void light_gone() override;
  void memory_freed() override { queue_.check_postponed(); }
  std::shared_future<void> print_over(EndedJob& job) override;
  void job_ended(EndedJob job) override;
  void may_stop() override;

  [[nodiscard]] QueueHold::Calls calls_of_hold();
  [[nodiscard]] PrintQueue::Calls calls_of_queue();
  [[nodiscard]] JobScheduler::Calls calls_of_scheduler();
  // True if a manual operation is running or a picture is shown.
  [[nodiscard]] bool controlled_by_hand() const {
    return manual_.state() != ManualState::Idle || !manual_.picture().empty();
  }
  void manual_changed();
  void end_manual_control();
  // Returns the text of the service manager's status line.
  [[nodiscard]] std::string readiness() const;
  [[nodiscard]] std::string metrics() const;
  // Passes the jobs that the previous process left, and its last end, to the history.
  void adopt_left_jobs();
  // Queries the history for parts that are due to be replaced, and reports them.
  void remind();
  void part_replaced(WearPart part);
  // Records the end of a job that was refused or removed before its turn.
  void note_refusal(EndedJob job);
  // Adds the job to the recent history and notifies all watching clients.
  void note_end(EndedJob job);
  void notify(const std::string& what, ControlServer::Delivery delivery);
  void stop_waiting_for_filing();

  PrinterContext context_;
  IncomingRouter incoming_router_;
  Spool spool_;
  JobReader reader_;
  QueueHold hold_;
  PrintQueue queue_;
  CurrentJob job_;
  JobScheduler scheduler_;
  JobHistory history_;
  HistoryWorker history_worker_;
  EndedJobNotices notices_;
  ManualProcess manual_;
  Reminders reminders_;
  PrinterStatus status_;
  PrinterControl control_;
  QueueControl queue_control_;
  Worker picture_worker_;
  ManualControl manual_control_;
  HistoryControl history_control_;
  ScreenControl screen_control_;
  std::unique_ptr<ControlServer> server_;
  std::optional<MetricsFile> metrics_file_;
  std::uint64_t manual_operations_logged_ = 0;
  Duration lit_{};  // upper bound of the light in all prints so far
  Ending ending_ = Ending::No;
  std::function<void(bool)> printing_;
  EventLoop::SourcePtr stop_timer_;
};

}  // namespace contourd
