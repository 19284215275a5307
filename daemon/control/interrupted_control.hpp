// The methods for a print that a power cut ended, while its part hangs on the plate: to let it go on, or to
// lift the part out. Independent of the transport. Event loop's thread only.
#pragma once

#include "daemon/control/control_method.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/printer_use.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class InterruptedControl {
 public:
  using Json = ControlMethod::Json;

  struct Parts {
    Spool& spool;
    QueueHold& hold;
    PrinterUse& use;
    ManualProcess& manual;
    const PrinterStatus& status;
  };
  // All arguments must outlive the control.
  InterruptedControl(const PrinterContext& context, const Parts& parts) : context_(context), parts_(parts) {}

  // Returns all methods by name; they return the status. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

  // Continues an interrupted print without a user, if the configuration says so and the machine is ready. To
  // be called at the start and when the machine may have become ready; tries once.
  void go_on_by_policy();

 private:
  // A job that is looked at before its print goes on.
  struct Look {
    std::optional<JobSettings> settings;
    std::string trouble;
  };

  Json rescue();
  // Returns how far the plate rises: to a limit switch at the top, else out of the vat, and no higher than
  // its travel from the greatest height that it may have. Throws ControlRefusal.
  [[nodiscard]] Nanometers way_out() const;
  void go_on(bool trusted, const ControlMethod::Later& later);
  // Returns the interrupted print. Throws ControlRefusal if there is none, or if the printer is in use.
  [[nodiscard]] const InterruptedPrint& require_interrupted() const;
  void looked_at(const ClaimedJob::Resumed& resumed, const Look& look, const ControlMethod::Later& later);

  const PrinterContext& context_;
  Parts parts_;
  bool tried_ = false;
};

}  // namespace contourd
