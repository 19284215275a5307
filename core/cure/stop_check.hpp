// A question whether a long computation is to end, asked now and then. Not thread-safe.
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <utility>

namespace contourd {

// Thrown where a computation was asked to stop.
class ComputationStopped final : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "the computation was stopped"; }
};

class StopCheck {
 public:
  // `is_stopped` may be empty: the computation is never stopped.
  explicit StopCheck(std::function<bool()> is_stopped = {}) : is_stopped_(std::move(is_stopped)) {}

  // Counts steps, each of some nanoseconds, and asks after many of them. Throws ComputationStopped.
  void spend(std::size_t steps) {
    spent_ += steps;
    if (spent_ < kSteps) return;
    spent_ = 0;
    if (is_stopped_ && is_stopped_()) throw ComputationStopped();
  }

 private:
  static constexpr std::size_t kSteps = 100'000;

  std::function<bool()> is_stopped_;
  std::size_t spent_ = 0;
};

}  // namespace contourd
