// The methods with which clients read and change the queue. Independent of the transport. Event loop's
// thread only.
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

  // All arguments must outlive the control.
  QueueControl(PrintQueue& queue, const CurrentJob& job, const PrinterStatus& status)
      : queue_(queue), job_(job), status_(status) {}

  // Returns all methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();
  // Returns the index of the named job. Throws ControlRefusal if it does not wait.
  [[nodiscard]] std::size_t number_of(const std::string& job) const;

 private:
  // The following methods return the queue, and throw ControlRefusal and InvalidParameters.
  [[nodiscard]] Json look(const Json& given) const;
  Json remove(const Json& given, const ControlCaller& caller);
  Json move(const Json& given);
  Json accept(const Json& given, const ControlCaller& caller);
  // Returns the index of the named job; nullopt if no job of that name waits. Throws ControlRefusal if
  // several jobs match.
  [[nodiscard]] std::optional<std::size_t> find(const std::string& job) const;
  // Throws the ControlRefusal for a job that is not in the queue.
  [[noreturn]] void refuse_to_accept(const std::string& job) const;

  PrintQueue& queue_;
  const CurrentJob& job_;
  const PrinterStatus& status_;
};

}  // namespace contourd
