// The methods that move and light the printer by hand while nothing prints. An operation ends when the
// connection that began it closes. Independent of the transport. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/control/control_method.hpp"
#include "daemon/control/printer_status.hpp"
#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/jobs/queue_hold.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

// An upload of a picture in pieces, because a message is short. There is one upload at a time; an upload
// from another connection replaces it.
class PictureUpload {
 public:
  // `most`: maximum size of a picture in bytes.
  explicit PictureUpload(std::size_t most) : most_(most) {}

  // Appends the piece at `from`; 0 starts a new upload. Returns the number of bytes so far. Throws
  // ControlRefusal if the piece does not continue this connection's upload, or if the picture becomes too
  // large.
  std::size_t add(std::uint64_t connection, std::size_t from, std::span<const std::uint8_t> piece);
  // Returns the connection's upload and forgets it. Throws ControlRefusal if there is none.
  [[nodiscard]] std::vector<std::uint8_t> take(std::uint64_t connection);
  // Forgets the upload of a closed connection.
  void drop(std::uint64_t connection);

 private:
  std::size_t most_;
  std::uint64_t connection_ = 0;  // 0: none
  std::vector<std::uint8_t> bytes_;
};

class ManualControl {
 public:
  using Json = ControlMethod::Json;

  struct Parts {
    QueueHold& hold;
    const CurrentJob& job;
    const JobScheduler& scheduler;
    const PrinterStatus& status;
  };
  // All arguments must outlive the control. Pictures are decoded on the worker's thread.
  ManualControl(const PrinterContext& context, const Parts& parts, ManualProcess& process, Worker& worker);

  // Returns all methods by name; all but inputs and upload return the status. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

  // Ends whatever the closed connection has begun.
  void disconnected(std::uint64_t connection);

 private:
  // Returns a method that moves or lights the printer.
  [[nodiscard]] ControlMethod begins(const char* description,
                                     Json (ManualControl::*method)(const Json&, const ControlCaller&),
                                     std::vector<ControlParameter> parameters);
  // Returns a method that makes the printer safe; every client may call it.
  [[nodiscard]] ControlMethod ends(const char* description, Json (ManualControl::*method)());
  Json home(const Json& given, const ControlCaller& caller);
  Json move(const Json& given, const ControlCaller& caller);
  Json move_unhomed(const Json& given, const ControlCaller& caller);
  Json stop();
  Json motor_off(const Json& given, const ControlCaller& caller);
  Json light_on(const Json& given, const ControlCaller& caller);
  Json light_off();
  void show(const Json& given, const ControlCaller& caller, ControlMethod::Later later);
  void read_uploaded(const ControlCaller& caller, Duration time, ControlMethod::Later later);
  Json present(Mask picture, const std::string& name, Duration time, const ControlCaller& caller);
  Json upload(const Json& given, const ControlCaller& caller);
  Json projector(const Json& given, const ControlCaller& caller);
  [[nodiscard]] Json inputs() const;

  void require_no_print(const std::string& instead) const;
  void require_free() const;
  void require_display() const;
  void require_motion_allowed() const;
  void require_way_down(const Json& given) const;
  [[nodiscard]] Nanometers target_of(const Json& given) const;
  [[nodiscard]] MillimetersPerSecond speed_of(const Json& given) const;
  Json begun_by(const ControlCaller& caller);

  const PrinterContext& context_;
  Parts parts_;
  ManualProcess& process_;
  Worker& worker_;
  PictureUpload upload_;
  // The connections that began the current operation and picture; 0 if none.
  std::uint64_t operation_owner_ = 0, picture_owner_ = 0;
  std::uint64_t reading_for_ = 0;  // the connection whose picture is being decoded; 0 if none
};

}  // namespace contourd
