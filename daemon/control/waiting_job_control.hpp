// The methods with which clients read and replace the ticket of a waiting job, and get its picture.
// Independent of the transport. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/control/control_method.hpp"
#include "daemon/control/queue_control.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/print_queue.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class WaitingJobControl {
 public:
  using Json = ControlMethod::Json;
  // Largest ticket that a request, of which a message has to have room for more, can contain.
  static constexpr std::size_t kMostTicketBytes = 7'168;
  // Pictures that are kept; the oldest goes first.
  static constexpr std::size_t kMostPictures = 8;

  struct Parts {
    Spool& spool;
    JobReader& reader;
    const PrintQueue& queue;
    const QueueControl& queue_control;
  };
  // All arguments must outlive the control.
  WaitingJobControl(const PrinterConfig& config, const Parts& parts) : config_(config), parts_(parts) {}

  // Returns all methods by name. The control must outlive them.
  [[nodiscard]] ControlMethods methods();

 private:
  struct Picture {
    std::uint64_t number = 0;
    std::string file;           // in incoming/
    std::uint64_t checked = 0;  // number of the check, after which the job's files are others
    std::vector<std::uint8_t> png{};
  };

  struct NewTicket {
    std::string file;  // the job's, in incoming/
    Json json;
  };

  void ticket(const Json& given, ControlMethod::Later later);
  void replace_ticket(const Json& given, ControlMethod::Later later);
  void try_ticket(NewTicket ticket, const JobSettings& settings, ControlMethod::Later later);
  void preview(const Json& given, ControlMethod::Later later);
  void drawn(Picture picture, const DrawnJob& job, const ControlMethod::Later& later);
  [[nodiscard]] const WaitingJob& job_of(const Json& given) const;

  const PrinterConfig& config_;
  Parts parts_;
  std::deque<Picture> pictures_;  // the oldest first
  std::uint64_t pictures_drawn_ = 0;
  bool drawing_ = false, trying_ = false;
};

}  // namespace contourd
