// The printer's jobs and its state, as contourd's answers tell them, in the terms of other print hosts. Event
// loop's thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

// Returns a number for a name, which stays the same as long as the name does: from 1 to 2^31 - 1, so that
// every client can hold it. Two names may have the same number.
[[nodiscard]] std::uint32_t id_of(std::string_view name);

// A job that waits, or is printed. Numbers that are not known yet are 0.
struct HostJob {
  std::string name;
  std::string file;           // in incoming/; the name for the print under way
  bool is_printing = false;   // includes its preparation and its end
  std::string state{};        // of a waiting job, as of contourd's queue
  std::string waiting_for{};  // why a waiting job waits, apart from its place
  std::string resin{};
  std::int64_t bytes = 0, layers = 0;
  double layer_um = 0, print_time_s = 0, resin_ml = 0;
  std::vector<std::string> asks{}, warnings{};

  [[nodiscard]] std::uint32_t id() const { return id_of(name); }
  // True if a client means this job by the name of its file. That of the print under way is no longer known.
  [[nodiscard]] bool is_file(const std::string& other) const;
};

// Returns the print under way and the first hundred waiting jobs, by contourd's `status` and `queue`, without
// those that are being removed.
[[nodiscard]] std::vector<HostJob> host_jobs(const ControlLink::Json& status, const ControlLink::Json& queue);
// Returns the print under way.
[[nodiscard]] std::optional<HostJob> host_print(const ControlLink::Json& status);

// The phases of a print, by NanoDLP's numbers for them.
enum class HostPhase { Idle = 0, Starting = 1, Pausing = 2, Paused = 3, Cancelling = 4, Printing = 5 };

struct HostStatus {
  std::string printer{};
  HostPhase phase = HostPhase::Idle;
  std::string text{};                   // the state for people, with the reason if the printer waits
  std::optional<HostJob> job{};         // the print under way
  std::optional<std::int64_t> layer{};  // the current layer, from 1; of an ended print, the last one
  std::int64_t layers = 0;              // of the print under way, or the ended one
  double time_left_s = 0;
  std::optional<double> height_mm{};
  bool is_lit = false;
};

// Reads contourd's status, one after another. Remembers the print, because the status at its end and after it
// has no layers.
class HostStatusReader {
 public:
  [[nodiscard]] HostStatus read(const ControlLink::Json& status);
  // Reports the print under way as one that is being cancelled, until it has ended.
  void is_cancelled() { cancelled_ = job_; }

 private:
  std::string job_, cancelled_;  // names; empty if there is none
  std::int64_t layers_ = 0;
  std::optional<HostStatus> printed_;  // the last status of this print that had a layer
};

}  // namespace contourd::web
