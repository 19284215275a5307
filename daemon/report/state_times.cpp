#include "daemon/report/state_times.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {

PrintActivity activity_of(PrintState state) {
  switch (state) {
    case PrintState::WarmingUp:
    case PrintState::Homing:
      return PrintActivity::Preparing;
    case PrintState::Exposing:
      return PrintActivity::Exposing;
    case PrintState::Lowering:
    case PrintState::Lifting:
    case PrintState::Raising:
    case PrintState::Braking:
    case PrintState::Halting:
    case PrintState::Parking:
      return PrintActivity::Moving;
    case PrintState::Paused:
    case PrintState::Held:
      return PrintActivity::Stopped;
    case PrintState::Idle:
    case PrintState::Settling:
    case PrintState::Showing:
    case PrintState::Igniting:
    case PrintState::Darkening:
    case PrintState::Extinguishing:
    case PrintState::Interrupting:
    case PrintState::Resting:
    case PrintState::AwaitingDark:
    case PrintState::Ending:
      break;
  }
  return PrintActivity::Waiting;
}

std::string_view name_of(PrintActivity activity) {
  switch (activity) {
    case PrintActivity::Preparing:
      return "preparing";
    case PrintActivity::Exposing:
      return "exposing";
    case PrintActivity::Moving:
      return "moving";
    case PrintActivity::Waiting:
      return "waiting";
    case PrintActivity::Stopped:
      return "stopped";
  }
  return "?";
}

void StateTimes::enter(PrintState state, TimePoint now) {
  expects(now >= since_, "times do not fall");
  totals_[static_cast<std::size_t>(state_)] += now - since_;
  while (now - start_ > width_ * static_cast<std::int64_t>(kMaxSlices))
    halve();
  const auto activity = static_cast<std::size_t>(activity_of(state_));
  for (TimePoint from = since_; from < now;) {
    const auto slice = static_cast<std::size_t>((from - start_) / width_);
    const TimePoint end = std::min(now, start_ + width_ * static_cast<std::int64_t>(slice + 1));
    if (slices_.size() <= slice) slices_.resize(slice + 1);
    slices_[slice][activity] += end - from;
    from = end;
  }
  since_ = now;
  state_ = state;
}

// Merges pairs of slices into half as many slices of twice the width.
void StateTimes::halve() {
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    const Slice slice = slices_[i];
    if (i % 2 == 0) slices_[i / 2] = {};
    for (std::size_t activity = 0; activity < slice.size(); ++activity)
      slices_[i / 2][activity] += slice[activity];
  }
  slices_.resize((slices_.size() + 1) / 2);
  width_ *= 2;
}

}  // namespace contourd
