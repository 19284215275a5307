#include "hw/gpio/step_engine.hpp"

#include <sched.h>
#include <time.h>

#include <algorithm>

namespace contourd {
namespace {}  // namespace

TimePoint monotonic_now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return TimePoint{std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec}};
}

StepEngine::StepEngine(OutputLine& step, OutputLine& direction, const StepTiming& timing, Now now)
    : step_(step), direction_(direction), timing_(timing), now_(now) {}

void StepEngine::start(const StepMove& move) noexcept {
  expects(!moving(), "no move is under way");
  move_ = move;
  sign_ = move.steps < 0 ? -1 : 1;
  from_ = position();
  made_before_ = history_.count();
  asked_to_stop_.reset();
  start_ns_ = 0;
  made_before_ramp_ = 0;
  stop_ = false;
  phase_.store(Phase::Handed, std::memory_order_release);
  work_.signal();
}

void StepEngine::stop() noexcept {
  if (!moving() || asked_to_stop_) return;
  const Ramp under_way = ramp();
  const std::int64_t made = (position() - from_) * sign_ - under_way.made;
  Stop stop{under_way.made, {}};
  if (under_way.start != Duration{0} && made > 0) {
    stop.elapsed = std::min(now_().time_since_epoch() - under_way.start, planned(under_way).due(made));
  }
  asked_to_stop_ = stop;
  stop_ = true;
}

// Seqlock: the step thread sets start_ns_ to 0 while it changes made_before_ramp_.
StepEngine::Ramp StepEngine::ramp() const noexcept {
  for (;;) {
    const std::int64_t start = start_ns_, made = made_before_ramp_;
    if (start == start_ns_) return {Duration{start}, made};
  }
}

void StepEngine::set_position(std::int64_t position) noexcept {
  expects(!moving(), "no move is under way");
  from_ += position - position_;
  position_ = position;
}

std::int64_t StepEngine::position_at(TimePoint time) const noexcept {
  const Ramp under_way = ramp();
  if (moving() && time > now_()) {
    std::int64_t steps = under_way.made;
    if (under_way.start != Duration{0}) {
      steps += planned(under_way).due_by(time.time_since_epoch() - under_way.start);
    }
    return from_ + sign_ * std::max(steps, (position() - from_) * sign_);
  }
  const std::uint64_t made = std::max(history_.count_at(time), made_before_) - made_before_;
  return from_ + sign_ * static_cast<std::int64_t>(made);
}

StepPlanner StepEngine::plan_of(std::int64_t steps) const noexcept {
  return move_.rise ? StepPlanner(steps, *move_.rise, move_.limits) : StepPlanner(steps, move_.limits);
}

StepPlanner StepEngine::planned(const Ramp& ramp) const noexcept {
  StepPlanner plan = plan_of(move_.steps * sign_ - ramp.made);
  if (asked_to_stop_) plan.stop_at(asked_to_stop_->made == ramp.made ? asked_to_stop_->elapsed : Duration{0});
  return plan;
}

Stalls StepEngine::stalls() const noexcept {
  const std::uint64_t count = stalls_;
  return {count, Duration{stall_late_ns_}, stall_speed_};
}

void StepEngine::halt() noexcept {
  halt_ = true;
  // Sequentially consistent on both sides: either the step thread sees the halt, or this loop sees stepping_.
  while (stepping_)
    sched_yield();
}

void StepEngine::inhibit() noexcept {
  inhibited_ = true;
  halt_soon();
}

bool StepEngine::begin() noexcept {
  work_.clear();
  Phase handed = Phase::Handed;
  if (!phase_.compare_exchange_strong(handed, Phase::Running, std::memory_order_acquire)) return false;
  plan_ = plan_of(move_.steps < 0 ? -move_.steps : move_.steps);
  stopped_ = false;
  harmless_ = move_.rise ? Duration::max()
                         : Duration{static_cast<Duration::rep>(
                               std::min(kIntervals / move_.limits.speed, in_seconds(kSwing)) * 1e9)};
  if (plan_.finished()) return finish(StepEnd::Completed), false;
  const int direction = move_.steps < 0 ? -1 : 1;
  if (direction != last_direction_) {
    if (!direction_.set(direction > 0)) return finish(StepEnd::LineRefused), false;
    last_direction_ = direction;
  }
  // The schedule begins after the direction's setup time, so no step can come within it.
  const TimePoint now = now_();
  start_ns_ = (now + timing_.direction_setup).time_since_epoch().count();
  planned_ = plan_.next();
  plan_rise(now);
  return true;
}

void StepEngine::act() noexcept {
  if (high_) {
    fall();
  } else {
    rise();
  }
}

void StepEngine::rise() noexcept {
  if (halted()) return finish(StepEnd::Halted);
  const TimePoint now = now_();
  const Duration late = now.time_since_epoch() - Duration{start_ns_} - planned_;
  if (late > harmless_ && come_to_rest(late)) return start_again(now, late);
  if (brake_ && plan_.speed_at(planned_) <= move_.pull_in) return finish(StepEnd::Halted);
  if ((stop_ || brake_) && !stopped_) return slow_down(now, late);
  if (now < due_) return;
  if (!make_step(now)) return;
  plan_.advance();
  keep_time(late);
  high_ = true;
  due_ = now_() + timing_.pulse_width;
}

// Makes a step. False if the move has ended instead.
bool StepEngine::make_step(TimePoint now) noexcept {
  stepping_ = true;
  if (halted()) {
    stepping_ = false;
    finish(StepEnd::Halted);
    return false;
  }
  const bool made = step_.set(true);
  if (made) {
    history_.add(now);
    position_.store(position_.load(std::memory_order_relaxed) + (move_.steps < 0 ? -1 : 1),
                    std::memory_order_release);
  }
  stepping_ = false;
  if (!made) finish(StepEnd::LineRefused);
  return made;
}

// Shifts the schedule if the step just made was late by more than a quarter of the following interval.
void StepEngine::keep_time(Duration late) noexcept {
  note_lateness(late);
  if (plan_.finished()) return;
  const Duration interval = plan_.next() - planned_;
  planned_ += interval;
  if (late <= interval / 4) return;
  start_ns_ = start_ns_ + late.count();
  ++late_;
}

void StepEngine::fall() noexcept {
  const TimePoint now = now_();
  if (now < due_) return;
  if (!step_.set(false)) return finish(StepEnd::LineRefused);
  high_ = false;
  if (plan_.finished()) return finish(stopped_ ? StepEnd::Stopped : StepEnd::Completed);
  plan_rise(now_());
}

// True if the motor has come to rest while it waited for the step that is due.
bool StepEngine::come_to_rest(Duration late) const noexcept {
  if (plan_.done() == 0) return false;  // the motor was at rest before
  const double interval_s = 1 / plan_.speed_at(planned_);
  return in_seconds(late) > std::max(interval_s / 4, std::min(kIntervals * interval_s, in_seconds(kSwing)));
}

void StepEngine::start_again(TimePoint now, Duration late) noexcept {
  ++late_;
  note_lateness(late);
  const double speed = plan_.speed_at(planned_);
  if (speed > move_.pull_in) {
    stall_late_ns_ = late.count();
    stall_speed_ = speed;
    ++stalls_;
    if (move_.ends_stalled) return finish(StepEnd::Stalled);
  }
  if (stop_ || brake_) return finish(StepEnd::Stopped);
  const std::int64_t left = plan_.total() - plan_.done();
  start_ns_ = 0;
  made_before_ramp_ += plan_.done();
  plan_ = StepPlanner(left, move_.limits);
  start_ns_ = now.time_since_epoch().count();
  planned_ = plan_.next();
  plan_rise(now);
}

// Slows down from now on. If a step is overdue, shifts the schedule so that the step is due now.
void StepEngine::slow_down(TimePoint now, Duration late) noexcept {
  stopped_ = true;
  if (late > Duration{0}) start_ns_ += late.count();
  const Duration elapsed = now.time_since_epoch() - Duration{start_ns_};
  plan_.stop_at(plan_.done() == 0 ? Duration{0} : elapsed);
  if (plan_.finished()) return finish(StepEnd::Stopped);
  planned_ = plan_.next();
  plan_rise(now);
}

void StepEngine::plan_rise(TimePoint now) noexcept {
  due_ = std::max(TimePoint{Duration{start_ns_}} + planned_, now + timing_.pulse_width);
}

void StepEngine::finish(StepEnd end) noexcept {
  end_ = end;
  phase_.store(Phase::Idle, std::memory_order_release);
  ended_.signal();
}

}  // namespace contourd
