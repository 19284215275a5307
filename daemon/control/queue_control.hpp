// The methods by which an owner's programs look at the queue and change it. They know no transport, as
// PrinterControl's. Event loop's thread only.
#pragma once

#include <optional>
#include <string>

#include "daemon/control/control_method.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/print_queue.hpp"

namespace contourd {

class QueueControl {
 public:
  using Json = ControlMethod::Json;

  // All must outlive the control.
  QueueControl(PrintQueue& queue, const CurrentJob& job, const PrinterStatus& status)
      : queue_(queue), job_(job), status_(status) {}

  // All of them, by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

 private:
  // These return the queue, and throw ControlRefusal and InvalidParameters.
  [[nodiscard]] Json look(const Json& given) const;
  Json remove(const Json& given, const ControlCaller& caller);
  Json move(const Json& given);
  Json accept(const Json& given, const ControlCaller& caller);
  // Of the one job that is meant; nothing when none of that name waits.
  [[nodiscard]] std::optional<std::size_t> find(const std::string& job) const;
  [[nodiscard]] std::size_t number_of(const std::string& job) const;
  // Says so of a job that has no question.
  [[noreturn]] void refuse_to_accept(const std::string& job) const;

  PrintQueue& queue_;
  const CurrentJob& job_;
  const PrinterStatus& status_;
};

}  // namespace contourd
