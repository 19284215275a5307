// Records of frames on their way from the thread that shows them to the one that writes them. One thread
// adds, another takes; neither waits, and nothing is allocated. 300 KB.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <span>

#include "daemon/frames/frame_record.hpp"

namespace contourd {

class FrameRing {
 public:
  static constexpr std::size_t kRoom = 4'096;  // 34 s of a new mask at each of 120 refreshes a second

  // Returns false if there is no room.
  [[nodiscard]] bool add(const FrameRecord& record) noexcept {
    const std::size_t added = added_.load(std::memory_order_relaxed);
    if (added - taken_.load(std::memory_order_acquire) == kRoom) return false;
    records_[added % kRoom] = record;
    added_.store(added + 1, std::memory_order_release);
    return true;
  }
  // Takes the oldest records, as many as there are and `to` has room for; returns their number.
  [[nodiscard]] std::size_t take(std::span<FrameRecord> to) noexcept {
    const std::size_t taken = taken_.load(std::memory_order_relaxed);
    const std::size_t number = std::min(added_.load(std::memory_order_acquire) - taken, to.size());
    for (std::size_t i = 0; i < number; ++i)
      to[i] = records_[(taken + i) % kRoom];
    taken_.store(taken + number, std::memory_order_release);
    return number;
  }
  [[nodiscard]] std::size_t size() const noexcept {
    const std::size_t taken = taken_.load(std::memory_order_acquire);
    return added_.load(std::memory_order_acquire) - taken;
  }

 private:
  std::array<FrameRecord, kRoom> records_{};
  std::atomic<std::size_t> added_{0}, taken_{0};
};

}  // namespace contourd
