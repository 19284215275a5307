// The time that a print spent in each of its states: in total, and by slices of its time. There are at most
// kMaxSlices slices, however long the print takes. A value; thread-safe like any value.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/print/print_states.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The activities as which the states are drawn.
enum class PrintActivity { Preparing, Exposing, Moving, Waiting, Stopped };
inline constexpr std::size_t kPrintActivities = 5;
inline constexpr std::size_t kPrintStates = static_cast<std::size_t>(PrintState::Ending) + 1;

[[nodiscard]] PrintActivity activity_of(PrintState state);
[[nodiscard]] std::string_view name_of(PrintActivity activity);

class StateTimes {
 public:
  static constexpr std::size_t kMaxSlices = 256;
  // The time of each activity within a slice.
  using Slice = std::array<Duration, kPrintActivities>;

  StateTimes() = default;
  // Begins in the state Idle at `start`.
  explicit StateTimes(TimePoint start) : start_(start), since_(start) {}

  // Enters a state and adds the time of the state before it. May enter the same state again. REQUIRES: times
  // do not fall.
  void enter(PrintState state, TimePoint now);

  [[nodiscard]] PrintState state() const { return state_; }
  // Returns the time spent in a state, up to the last enter(), as all other times.
  [[nodiscard]] Duration in(PrintState state) const { return totals_[static_cast<std::size_t>(state)]; }
  [[nodiscard]] Duration total() const { return since_ - start_; }
  // Returns the slices from the start on, each slice_width() long; the last one may be shorter.
  [[nodiscard]] std::span<const Slice> slices() const { return slices_; }
  [[nodiscard]] Duration slice_width() const { return width_; }

 private:
  void halve();

  TimePoint start_{}, since_{};
  PrintState state_ = PrintState::Idle;
  std::array<Duration, kPrintStates> totals_{};
  Duration width_ = std::chrono::milliseconds(100);
  std::vector<Slice> slices_;
};

}  // namespace contourd
