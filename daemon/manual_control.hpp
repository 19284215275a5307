// The methods by which an owner moves and lights the printer by hand, while nothing prints. What somebody has
// begun ends with the connection that it came by. They know no transport. Event loop's thread only.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/control_method.hpp"
#include "daemon/current_job.hpp"
#include "daemon/job_scheduler.hpp"
#include "daemon/manual_process.hpp"
#include "daemon/printer_context.hpp"
#include "daemon/printer_status.hpp"
#include "daemon/queue_hold.hpp"

namespace contourd {

class ManualControl {
 public:
  using Json = ControlMethod::Json;

  struct Parts {
    const QueueHold& hold;
    const CurrentJob& job;
    const JobScheduler& scheduler;
    const PrinterStatus& status;
  };
  // All must outlive the control.
  ManualControl(const PrinterContext& context, const Parts& parts, ManualProcess& process)
      : context_(context), parts_(parts), process_(process) {}

  // All of them, by name; each but inputs returns the status. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

  // A connection is no more: what it began ends.
  void disconnected(std::uint64_t connection);

 private:
  Json home(const Json& given, const ControlCaller& caller);
  Json move(const Json& given, const ControlCaller& caller);
  Json stop();
  Json motor_off();
  Json light_on(const Json& given, const ControlCaller& caller);
  Json light_off();
  Json show(const Json& given, const ControlCaller& caller);
  Json projector(const Json& given, const ControlCaller& caller);
  [[nodiscard]] Json inputs() const;

  void require_no_print(const std::string& instead) const;
  void require_free() const;
  void require_motion_allowed() const;
  void require_way_down(const Json& given) const;
  [[nodiscard]] Nanometers target_of(const Json& given) const;
  [[nodiscard]] MillimetersPerSecond speed_of(const Json& given) const;
  Json begun_by(const ControlCaller& caller);

  const PrinterContext& context_;
  Parts parts_;
  ManualProcess& process_;
  std::uint64_t operation_owner_ = 0, picture_owner_ = 0;  // connections; 0: none
};

}  // namespace contourd
