// The time that a print spent in each of its states: in total, and by slices of its time. There are at most
// kMaxSlices slices, however long the print takes. A value; thread-safe like any value.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "daemon/print/print_mode.hpp"
#include "hw/clock.hpp"

namespace contourd {

class StateTimes {
 public:
  static constexpr std::size_t kMaxSlices = 256;
  // The time of each activity within a slice.
  using Slice = std::array<Duration, kPrintActivities>;
  struct Total {
    PrintState state;
    Duration time{};
  };

  StateTimes() = default;
  // Begins in kIdle at `start`.
  explicit StateTimes(TimePoint start) : start_(start), since_(start) {}

  // Enters a state and adds the time of the state before it. May enter the same state again. REQUIRES: times
  // do not fall.
  void enter(const PrintState& state, TimePoint now);

  [[nodiscard]] const PrintState& state() const { return state_; }
  // Returns the times spent in the states, in their order, up to the last enter(), as all other times. A
  // state that was never entered may have no name.
  [[nodiscard]] std::span<const Total> totals() const { return totals_; }
  [[nodiscard]] Duration total() const { return since_ - start_; }
  // Returns the slices from the start on, each slice_width() long; the last one may be shorter.
  [[nodiscard]] std::span<const Slice> slices() const { return slices_; }
  [[nodiscard]] Duration slice_width() const { return width_; }

 private:
  void halve();

  TimePoint start_{}, since_{};
  PrintState state_ = kIdle;
  std::vector<Total> totals_;  // by the state's number
  Duration width_ = std::chrono::milliseconds(100);
  std::vector<Slice> slices_;
};

// Returns the times of all states by their causes.
[[nodiscard]] TimeByCause time_by_cause(const StateTimes& states);

}  // namespace contourd
