#include "daemon/report/state_times.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {

void StateTimes::enter(const PrintState& state, TimePoint now) {
  expects(now >= since_, "times do not fall");
  if (totals_.size() <= state_.number) totals_.resize(state_.number + 1);
  totals_[state_.number].state = state_;
  totals_[state_.number].time += now - since_;
  while (now - start_ > width_ * static_cast<std::int64_t>(kMaxSlices))
    halve();
  const auto activity = static_cast<std::size_t>(state_.activity);
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

TimeByCause time_by_cause(const StateTimes& states) {
  TimeByCause times;
  for (const auto& [state, time] : states.totals())
    times[state.cause] += time;
  return times;
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
