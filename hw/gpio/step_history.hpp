// The times of the last steps: written by the step thread without a lock, read by other threads.
// Preallocated.
//
// Invariants:
//  1. One thread adds times, in ascending order.
//  2. count_ only grows, by one, after the time that it counts is written, so a reader of count_ may read
//     that time.
//  3. Step n has its time at n % kKept until step n + kKept is added. So a reader that the writer overtakes
//     by up to 64 steps reads only the times that it asked for.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hw/clock.hpp"

namespace contourd {

class StepHistory {
 public:
  // Four seconds at 4,000 steps/s.
  static constexpr std::uint64_t kKept = 16'384;

  // Adds a step's time. One thread only.
  void add(TimePoint at) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    times_[n % kKept].store(at.time_since_epoch().count(), std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  // Returns the number of steps since the beginning. Any thread.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }

  // Returns how many of all steps were made at or before `time`. For a time before the oldest kept step,
  // returns the number of steps that are no longer kept. Any thread.
  [[nodiscard]] std::uint64_t count_at(TimePoint time) const noexcept {
    std::uint64_t high = count();
    // The writer may be overwriting the oldest times, so a few of them are left out.
    constexpr std::uint64_t kMargin = 64;
    std::uint64_t low = high > kKept - kMargin ? high - (kKept - kMargin) : 0;
    const std::int64_t ns = time.time_since_epoch().count();
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if (times_[middle % kKept].load(std::memory_order_relaxed) <= ns) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

 private:
  std::array<std::atomic<std::int64_t>, kKept> times_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace contourd
