// The thread that makes the steps: waits until each is due, by absolute deadlines on CLOCK_MONOTONIC, and
// does what the engine says. Runs with SCHED_FIFO, on a stack that is in memory, with the program's memory as
// it stands locked (what is allocated later, models above all, is not: the thread does not touch it). Where
// the system refuses either, it runs all the same and says so.
#pragma once

#include <pthread.h>

#include <atomic>
#include <string>
#include <vector>

#include "hw/gpio/step_engine.hpp"

namespace contourd {

// A thread with a deadline to keep.
class RealtimeThread {
 public:
  // Starts a thread named `name` (15 letters at most) that runs `body(argument)` with SCHED_FIFO `priority`
  // where that is allowed. Throws std::system_error when there can be no thread.
  RealtimeThread(const char* name, int priority, void* (*body)(void*), void* argument);
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;
  ~RealtimeThread();  // waits for the body to return

  // A sentence for each thing that the system refused; none when all is as it should be.
  [[nodiscard]] const std::vector<std::string>& refusals() const { return refusals_; }

 private:
  static void* start(void* self);
  void make_thread();

  void* (*body_)(void*);
  void* argument_;
  std::atomic<bool> started_{false};
  pthread_t thread_{};
  std::vector<std::string> refusals_;
};

// Waits for deadlines. A thread wakes a little after the time it asked for: the wait is shortened by what
// that took at the least lately, and the last microseconds are spent looking at the clock.
class DeadlineWait {
 public:
  // Returns at `due`, never before unless `interrupted()`; sleeps at most 10 ms without looking for that.
  template <typename Interrupted>
  void until(TimePoint due, Interrupted interrupted) noexcept {
    for (TimePoint now = monotonic_now(); now < due && !interrupted(); now = monotonic_now())
      sleep(now, due);
  }

 private:
  void sleep(TimePoint now, TimePoint due) noexcept;

  Duration lead_{0};
};

class StepThread {
 public:
  // The engine must outlive the thread.
  StepThread(StepEngine& engine, int priority);
  // Halts the engine and ends the thread.
  ~StepThread();

  [[nodiscard]] const std::vector<std::string>& refusals() const { return thread_.refusals(); }

 private:
  void run() noexcept;

  StepEngine& engine_;
  std::atomic<bool> quit_{false};
  DeadlineWait wait_;
  RealtimeThread thread_;  // last: runs while the others are there
};

}  // namespace contourd
