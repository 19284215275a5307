#include "hw/gpio/step_engine.hpp"

#include <sched.h>
#include <time.h>

#include <algorithm>

namespace contourd {

TimePoint monotonic_now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return TimePoint{std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec}};
}

StepEngine::StepEngine(OutputLine& step, OutputLine& direction, const StepTiming& timing, Now now)
    : step_(step), direction_(direction), timing_(timing), now_(now) {}

void StepEngine::start(const StepMove& move) noexcept {
  move_ = move;
  sign_ = move.steps < 0 ? -1 : 1;
  from_ = position();
  made_before_ = history_.count();
  foreseen_ = StepPlanner(move.steps * sign_, move.limits);
  start_ns_ = 0;
  stop_ = false;
  halt_ = false;
  phase_.store(Phase::Handed, std::memory_order_release);
  work_.signal();
}

void StepEngine::stop() noexcept {
  if (!moving()) return;
  const std::int64_t start = start_ns_;
  foreseen_.stop_at(start == 0 ? Duration{0} : now_().time_since_epoch() - Duration{start});
  stop_ = true;
}

void StepEngine::set_position(std::int64_t position) noexcept {
  from_ += position - position_;
  position_ = position;
}

std::int64_t StepEngine::position_at(TimePoint time) const noexcept {
  const std::int64_t start = start_ns_;
  if (start == 0) return from_;
  if (moving() && time > now_()) {
    const std::int64_t planned = foreseen_.due_by(time.time_since_epoch() - Duration{start});
    return from_ + sign_ * std::max(planned, (position() - from_) * sign_);
  }
  const std::uint64_t made = std::max(history_.count_at(time), made_before_) - made_before_;
  return from_ + sign_ * static_cast<std::int64_t>(made);
}

LateSteps StepEngine::late_steps() const noexcept {
  return {late_, Duration{worst_ns_}};
}

void StepEngine::halt() noexcept {
  halt_ = true;
  // Sequentially consistent on both sides: either the thread sees the halt, or this sees the step being made.
  while (stepping_)
    sched_yield();
}

void StepEngine::bar() noexcept {
  barred_ = true;
  halt_soon();
}

bool StepEngine::begin() noexcept {
  work_.clear();
  Phase handed = Phase::Handed;
  if (!phase_.compare_exchange_strong(handed, Phase::Running, std::memory_order_acquire)) return false;
  plan_ = StepPlanner(move_.steps < 0 ? -move_.steps : move_.steps, move_.limits);
  stopped_ = false;
  if (plan_.finished()) return finish(StepEnd::Completed), false;
  const int direction = move_.steps < 0 ? -1 : 1;
  if (direction != last_direction_) {
    if (!direction_.set(direction > 0)) return finish(StepEnd::LineRefused), false;
    last_direction_ = direction;
  }
  // The schedule begins behind the direction's setup, so no step can come within it.
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
  if (halt_ || barred_) return finish(StepEnd::Halted);
  TimePoint now = now_();
  if (stop_ && !stopped_) slow_down(now);
  if (plan_.finished()) return finish(StepEnd::Stopped);
  if (now < due_) return;
  if (!make_step(now)) return;
  plan_.advance();
  keep_time(now);
  high_ = true;
  due_ = now_() + timing_.pulse_width;
}

// False when the move has ended instead.
bool StepEngine::make_step(TimePoint now) noexcept {
  stepping_ = true;
  if (halt_ || barred_) {
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

// Shifts the schedule when the step just made was late by more than a quarter of the interval behind it.
void StepEngine::keep_time(TimePoint now) noexcept {
  const Duration late = now.time_since_epoch() - Duration{start_ns_} - planned_;
  if (late.count() > worst_ns_) worst_ns_ = late.count();
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

void StepEngine::slow_down(TimePoint now) noexcept {
  stopped_ = true;
  plan_.stop_at(now.time_since_epoch() - Duration{start_ns_});
  if (plan_.finished()) return;
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
