#include "hw/gpio/wake_up_latency.hpp"

#include <algorithm>
#include <array>

#include "hw/gpio/axis_threads.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {
namespace {

// The number of wake-ups for each microsecond of lateness. The last entry includes all that are later.
using Histogram = std::array<std::uint32_t, 10'000>;

struct Measurement {
  Duration interval{}, lasting{};
  Histogram latenesses{};
  std::uint64_t count = 0;
  Duration worst{};

  void add(Duration late) noexcept {
    const auto microseconds = static_cast<std::size_t>(std::max<Duration::rep>(late.count(), 0) / 1'000);
    ++latenesses[std::min(microseconds, latenesses.size() - 1)];
    ++count;
    worst = std::max(worst, late);
  }

  // Runs on the thread. As with steps, a wake-up that is late by more than a quarter of an interval shifts
  // the rest.
  void run() noexcept {
    DeadlineWait wait;
    TimePoint due = monotonic_now() + std::chrono::milliseconds{1};
    for (const TimePoint end = due + lasting; due < end; due += interval) {
      wait.until(due, [] { return false; });
      const Duration late = monotonic_now() - due;
      add(late);
      if (late > interval / 4) due += late;
    }
  }

  [[nodiscard]] Duration p99() const {
    std::uint64_t within = 0;
    std::size_t microseconds = 0;
    while (microseconds < latenesses.size() && (within += latenesses[microseconds]) * 100 < count * 99)
      ++microseconds;
    return std::min(worst, Duration{std::chrono::microseconds{microseconds + 1}});
  }
};

}  // namespace

double WakeUpLatency::sustainable_rate(double most) const {
  if (worst > StepEngine::kSwing) return 0;
  if (p99 > Duration{0}) most = std::min(most, 0.5 / in_seconds(p99));
  if (worst > Duration{0}) most = std::min(most, StepEngine::kIntervals / in_seconds(worst));
  return most;
}

WakeUpLatency measure_wake_up_latency(double rate, int priority, Duration lasting) {
  Measurement measurement;
  measurement.interval = Duration{static_cast<Duration::rep>(1e9 / rate)};
  measurement.lasting = lasting;
  WakeUpLatency latency;
  {
    const RealtimeThread thread(
        "contourd-wakes", priority,
        [](void* self) -> void* {
          static_cast<Measurement*>(self)->run();
          return nullptr;
        },
        &measurement);
    latency.refusals = thread.refusals();
  }
  latency.count = measurement.count;
  latency.worst = measurement.worst;
  latency.p99 = measurement.p99();
  return latency;
}

}  // namespace contourd
