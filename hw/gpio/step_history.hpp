// When the last steps were made: written by the stepping thread without a lock, read by another.
// Preallocated.
//
// Invariants:
//  1. One thread adds, each time no earlier than the one before.
//  2. count_ only grows, by one, and behind the time that it counts: whoever has read it may read that time.
//  3. Step n has its time at n % kKept until step n + kKept is added. So a reader that is up to 64 steps
//     slower than the writer reads none but those that it asked for.
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

  // One thread.
  void add(TimePoint at) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    times_[n % kKept].store(at.time_since_epoch().count(), std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  // Any thread. Steps made since the beginning.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }

  // Any thread. How many of all steps were made at `time` or before, for a time within what is kept; for an
  // earlier one the number of those no longer kept.
  [[nodiscard]] std::uint64_t count_at(TimePoint time) const noexcept {
    std::uint64_t high = count();
    // The writer may be about to overwrite the oldest: a few are left out.
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
