// How long a print was in each of its states: in all, and along its time in slices, of which there are never
// more than kMaxSlices, however long it takes. A value; thread-safe as any value is.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/print/print_states.hpp"
#include "hw/clock.hpp"

namespace contourd {

// What the states are drawn as.
enum class PrintActivity { Preparing, Exposing, Moving, Waiting, Stopped };
inline constexpr std::size_t kPrintActivities = 5;
inline constexpr std::size_t kPrintStates = static_cast<std::size_t>(PrintState::Ending) + 1;

[[nodiscard]] PrintActivity activity_of(PrintState state);
[[nodiscard]] std::string_view name_of(PrintActivity activity);

class StateTimes {
 public:
  static constexpr std::size_t kMaxSlices = 256;
  // How long each activity lasted within a slice.
  using Slice = std::array<Duration, kPrintActivities>;

  StateTimes() = default;
  // Idle from `start` on.
  explicit StateTimes(TimePoint start) : start_(start), since_(start) {}

  // Counts what the state before it lasted. The same state again does no harm. REQUIRES: times that do not
  // fall.
  void enter(PrintState state, TimePoint now);

  [[nodiscard]] PrintState state() const { return state_; }
  // Up to the last enter(), as the rest is.
  [[nodiscard]] Duration in(PrintState state) const { return totals_[static_cast<std::size_t>(state)]; }
  [[nodiscard]] Duration total() const { return since_ - start_; }
  // From the start, each of slice_width(); the last one is not over.
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
