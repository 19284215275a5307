// The record of a print under way: its layers, interruptions and times, from which its report is made. Event
// loop's thread only.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/print/print_mode.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/system/event_loop.hpp"
#include "hw/clock.hpp"
#include "hw/machine.hpp"

namespace contourd {

class PrintRecord {
 public:
  // Begins the record of a print that begins now. `masks` is the folder in which the machine saves the masks
  // that it shows. Machine and clock must outlive the record.
  PrintRecord(Machine& machine, Clock& clock, std::optional<std::filesystem::path> masks);

  void add(const LayerRecord& layer) {
    layers_.push_back(layer);
    layers_.back().done_after = elapsed();
  }
  // Adds the peel of a layer to its record, which is among the last.
  void add(std::int32_t layer, const PeelRecord& peel);
  // Records that the print is in this state from now on, at this layer, counted from 0.
  void enter(const PrintState& state, std::int32_t layer);
  void add_interruption(std::int32_t layer, const std::string& what);
  // Records a change, which replaces the last one of the same setting if that is for the same layer.
  // REQUIRES: there are fewer than kMostChanges.
  void add(const SettingChange& change);
  // Records the plan of the rises that are left, which replaces the one before from its height on. Nothing is
  // recorded if no rise is left that is worth a motion.
  void add(ChangedForecast plan);
  void add(Exclusion exclusion) { exclusions_.push_back(std::move(exclusion)); }
  // Records a turn of the event loop during which there was or may have been light; the longest is
  // kept.
  void add_lit_turn(const EventLoop::Turn& turn);

  [[nodiscard]] const std::vector<LayerRecord>& layers() const { return layers_; }
  static constexpr std::size_t kMostChanges = 1000;
  [[nodiscard]] const std::vector<SettingChange>& changes() const { return changes_; }
  [[nodiscard]] const std::vector<Exclusion>& exclusions() const { return exclusions_; }
  // Returns the time since the print began, by the machine's clock.
  [[nodiscard]] Duration elapsed() const { return clock_.now() - started_; }

  // Returns the time since the print began, by cause.
  [[nodiscard]] TimeByCause times() const;

  // Ends the record and moves its layers and stops into a report. Leaves out what the record does not know:
  // job, printer, outcome and reason, summary, findings, the time to the first mask.
  [[nodiscard]] PrintReport take_report();

 private:
  [[nodiscard]] std::uint64_t late_steps() const;

  Machine& machine_;
  Clock& clock_;
  std::optional<std::filesystem::path> masks_;
  TimePoint started_;
  std::uint64_t late_steps_then_;  // the axis' count when the print began
  std::chrono::system_clock::time_point started_at_;
  std::vector<LayerRecord> layers_;
  std::vector<SettingChange> changes_;
  std::vector<ChangedForecast> changed_rises_;
  std::vector<Exclusion> exclusions_;
  StateTimes states_;
  PrintStops stops_;
  bool pause_known_ = false;       // the pause under way is the last of stops_.pauses
  EventLoop::Turn busiest_lit_{};  // the longest turn with light
};

}  // namespace contourd
