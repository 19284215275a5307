#include "hw/gpio/step_planner.hpp"

#include <algorithm>

namespace contourd {
namespace {

Duration nearest_nanosecond(double s) {
  return Duration{static_cast<Duration::rep>(s * 1e9 + 0.5)};
}

// Returns the number of steps whose middle lies within `distance`.
std::int64_t steps_within(double distance) {
  return static_cast<std::int64_t>(distance + 0.5);
}

}  // namespace

Duration StepPlanner::time_of(std::int64_t step) const noexcept {
  return nearest_nanosecond(curve_.time_at(static_cast<double>(step) + 0.5));
}

std::int64_t StepPlanner::due_by(Duration elapsed) const noexcept {
  return std::min(steps_within(curve_.position_at(in_seconds(elapsed))), total_);
}

void StepPlanner::stop_at(Duration elapsed) noexcept {
  curve_.stop_at(in_seconds(elapsed));
  total_ = std::clamp(steps_within(curve_.distance()), done_, total_);
}

Duration StepPlanner::duration() const noexcept {
  return nearest_nanosecond(curve_.duration_s());
}

}  // namespace contourd
