#include "hw/gpio/debounce.hpp"

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

std::optional<TimePoint> Debounce::due() const noexcept {
  return moving_ ? std::optional(last_ + lasting_) : std::nullopt;
}

std::optional<Debounce::Settled> Debounce::settle(TimePoint now) noexcept {
  if (!moving_ || now - last_ < lasting_) return std::nullopt;
  moving_ = false;
  const bool changed = raw_ != settled_;
  settled_ = raw_;
  return Settled{settled_, changed, first_[settled_ ? 1 : 0].value_or(last_)};
}

}  // namespace contourd
