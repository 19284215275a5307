#include "hw/gpio/contact.hpp"

#include <algorithm>

namespace contourd {

void Debounce::edge(bool level, TimePoint at) noexcept {
  if (!moving_) first_ = {};
  last_ = moving_ ? std::max(last_, at) : at;
  moving_ = true;
  raw_ = level;
  auto& first = first_[level ? 1 : 0];
  if (!first || at < *first) first = at;
}

std::optional<Debounce::Settled> Debounce::settle(TimePoint now) noexcept {
  if (!moving_ || now - last_ < lasting_) return std::nullopt;
  moving_ = false;
  const bool changed = raw_ != settled_;
  settled_ = raw_;
  return Settled{settled_, changed, first_[settled_ ? 1 : 0].value_or(last_)};
}

void SafetyContact::edge(bool unsafe, TimePoint at) noexcept {
  first_ = moving_ ? std::min(first_, at) : at;
  last_ = moving_ ? std::max(last_, at) : at;
  moving_ = true;
  unsafe_ = unsafe;
}

std::optional<TimePoint> SafetyContact::due() const noexcept {
  if (!moving_) return std::nullopt;
  if (state_ == SafetyState::Safe) return first_;
  if (!unsafe_) return last_ + debounce_;
  return state_ == SafetyState::Debouncing ? std::optional(first_ + debounce_) : std::nullopt;
}

std::optional<SafetyContact::Change> SafetyContact::change(TimePoint now) noexcept {
  if (!moving_) return std::nullopt;
  if (state_ == SafetyState::Safe) return step_to(SafetyState::Debouncing, first_);
  const Duration lasted = (unsafe_ ? now : last_) - first_;
  if (state_ == SafetyState::Debouncing && lasted >= debounce_) return step_to(SafetyState::Unsafe, first_);
  if (unsafe_ || now - last_ < debounce_) return std::nullopt;
  moving_ = false;
  return step_to(SafetyState::Safe, last_);
}

SafetyContact::Change SafetyContact::step_to(SafetyState state, TimePoint since) noexcept {
  const Change change{state_, state, since};
  state_ = state;
  return change;
}

}  // namespace contourd
