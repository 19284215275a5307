#include "hw/watchdog/light_deadline.hpp"

#include <algorithm>

namespace contourd {

void LightDeadline::arm(const WatchedExposure& exposure, TimePoint sent, TimePoint now) {
  exposure_ = exposure;
  times_ = 0;
  heard_ = std::min(sent, now);
}

void LightDeadline::heartbeat(const WatchedExposure& exposure, TimePoint sent, TimePoint now) {
  if (!exposure_ || exposure_->number != exposure.number) return;
  exposure_ = exposure;
  heard_ = std::max(heard_, std::min(sent, now));
}

LightTrip LightDeadline::trip(TimePoint now) const {
  if (gone_) return LightTrip::Death;
  if (now - heard_ >= kMaxSilence) return LightTrip::Silence;
  if (!exposure_->off_asked && now - exposure_->end >= kMaxOverrun) return LightTrip::Overrun;
  return LightTrip::None;
}

LightDeadline::Act LightDeadline::due(TimePoint now) {
  Act act;
  if (!exposure_) {
    act.end = gone_;
    return act;
  }
  const LightTrip reason = trip(now);
  if (!tripped()) {
    if (reason == LightTrip::None) return act;
    act.trip = reason;
    send_off(now, act);
  } else if (now >= again_) {
    again_ = now + kAgain;
    if (times_ < kTimes || reason != LightTrip::None) send_off(now, act);
  }
  act.end = gone_ && times_ >= kTimes;
  return act;
}

// Blanking the display may block for some refreshes, so it waits for the second light off, which is the first
// that is certain to be outside the projector's gap.
void LightDeadline::send_off(TimePoint now, Act& act) {
  ++times_;
  act.light_off = true;
  act.display_black = times_ == 2;
  again_ = now + (times_ < kTimes ? gap_ : kAgain);
}

std::optional<TimePoint> LightDeadline::next() const {
  if (!exposure_) return std::nullopt;
  if (tripped()) return again_;
  const TimePoint silent = heard_ + kMaxSilence;
  return exposure_->off_asked ? silent : std::min(silent, exposure_->end + kMaxOverrun);
}

}  // namespace contourd
