// The methods vat and preflight of the control socket. Independent of the transport. Event loop's thread
// only.
#pragma once

#include <optional>
#include <string>

#include "daemon/control/control_method.hpp"
#include "daemon/control/preflight.hpp"
#include "daemon/control/queue_control.hpp"
#include "daemon/history/history_worker.hpp"
#include "daemon/history/reminders.hpp"
#include "daemon/history/vat.hpp"
#include "daemon/jobs/job_claims.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"

namespace contourd {

class PreflightControl {
 public:
  using Json = ControlMethod::Json;

  struct Parts {
    Spool& spool;
    Vat& vat;
    const PrintQueue& queue;
    const QueueControl& queue_control;
    const QueueHold& hold;
    HistoryWorker& history;
    const Reminders& reminders;
  };
  // All arguments must outlive the control.
  PreflightControl(const PrinterContext& context, const Parts& parts) : context_(context), parts_(parts) {}

  // Returns these methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

 private:
  [[nodiscard]] Json vat_json() const;
  void vat(const Json& given, ControlMethod::Later later);
  // Asks the disk and the sensor, then the history.
  void preflight(const std::string& job, const ControlCaller& caller, ControlMethod::Later later);
  // Returns the facts that are known at once.
  [[nodiscard]] PreflightFacts facts() const;

  const PrinterContext& context_;
  Parts parts_;
};

}  // namespace contourd
