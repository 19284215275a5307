// The record of one print, for its owner.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/print_job.hpp"

namespace contourd {

// While the light is on or not confirmed off, no callback of the event loop is to take longer.
inline constexpr Duration kLongestLitTurn = std::chrono::milliseconds(10);

struct PrintReport {
  std::string job;
  std::string printer;
  PrintOutcome outcome = PrintOutcome::Failed;
  std::string reason;  // why it failed
  JobSummary summary;
  std::optional<PrintFindings> findings;   // nothing when the print ended before its analysis
  std::vector<LayerRecord> layers;         // those that were exposed
  std::vector<std::string> interruptions;  // "layer 7: the lid was opened", in their order
  std::chrono::system_clock::time_point started,
      ended;                                   // for people; durations come from the monotonic clock
  Duration print_time{};                       // by the machine's clock
  std::uint64_t late_steps = 0;                // of the motor
  EventLoop::Turn busiest_lit;                 // of those while there was or may have been light
  Duration first_mask_after{};                 // from the file's arrival, or from the end of its wait
  std::optional<std::filesystem::path> masks;  // where the simulated display kept them
  std::vector<std::uint8_t> preview_png;
};

}  // namespace contourd
