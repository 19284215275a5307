// What is written down of a print while it is under way: its layers, what interrupted it, its times. Its
// report is made of that. Event loop's thread only.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/print/print_process.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/system/event_loop.hpp"
#include "hw/clock.hpp"
#include "hw/machine.hpp"

namespace contourd {

class PrintRecord {
 public:
  // The print begins now. `masks` is where the machine keeps what it shows. Machine and clock must outlive
  // the record.
  PrintRecord(Machine& machine, Clock& clock, std::optional<std::filesystem::path> masks);

  void add(const LayerRecord& layer) { layers_.push_back(layer); }
  // The print, at this layer, is in this state from now on. Layers count from 0.
  void enter(PrintState state, std::int32_t layer);
  void add_interruption(std::int32_t layer, const std::string& what);
  // One in which there was or may have been light: the longest is kept.
  void add_lit_turn(const EventLoop::Turn& turn);

  [[nodiscard]] const std::vector<LayerRecord>& layers() const { return layers_; }
  // By the machine's clock.
  [[nodiscard]] Duration elapsed() const { return clock_.now() - started_; }

  // The print ends now. Takes the layers and stops; what the record does not know is left out: job,
  // printer, outcome and reason, summary, findings, the time to the first mask.
  [[nodiscard]] PrintReport take_report();

 private:
  [[nodiscard]] std::uint64_t late_steps() const;

  Machine& machine_;
  Clock& clock_;
  std::optional<std::filesystem::path> masks_;
  TimePoint started_;
  std::uint64_t late_steps_then_;  // of the axis
  std::chrono::system_clock::time_point started_at_;
  std::vector<LayerRecord> layers_;
  StateTimes states_;
  PrintStops stops_;
  bool pause_known_ = false;  // the one under way is the last of those that are kept
  EventLoop::Turn busiest_lit_{};
};

}  // namespace contourd
