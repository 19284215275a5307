// The printer's status and queue as JSON values for clients. The size of a reply is bounded, whatever is in
// the spool, because it is built while a light may be on. Event loop's thread only.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/camera/camera.hpp"
#include "daemon/control/printer_metrics.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/history/reminders.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class PrinterStatus {
 public:
  using Json = nlohmann::ordered_json;

  struct Parts {
    const Spool& spool;
    const PrintQueue& queue;
    const JobScheduler& scheduler;
    const QueueHold& hold;
    const CurrentJob& job;
    const JobHistory& history;
    const ManualProcess& manual;
    const Reminders& reminders;
    const Camera& camera;
  };
  // All arguments must outlive the status.
  PrinterStatus(const PrinterContext& context, const Parts& parts) : context_(context), parts_(parts) {}

  [[nodiscard]] Json status() const;
  [[nodiscard]] PrinterMetrics metrics() const;
  // Returns the waiting jobs in their order, with the details of the first ones, or only of job `number`
  // (from 0), and the files that are still arriving. REQUIRES: there is a job with that number.
  [[nodiscard]] Json queue(std::optional<std::size_t> number = std::nullopt) const;

 private:
  [[nodiscard]] std::string_view state() const;
  [[nodiscard]] Json job() const;
  void add_print(Json& job) const;
  [[nodiscard]] Json camera() const;
  [[nodiscard]] bool dark() const;
  [[nodiscard]] Json manual() const;
  [[nodiscard]] Json waiting_job(std::size_t number) const;
  [[nodiscard]] std::string_view state_of(const WaitingJob& job) const;
  [[nodiscard]] std::string reason_to_wait(std::size_t number) const;
  void add_incoming(Json& status) const;
  void add_reasons_to_wait(Json& status) const;

  const PrinterContext& context_;
  Parts parts_;
};

}  // namespace contourd
