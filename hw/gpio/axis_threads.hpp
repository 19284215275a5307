// The two real-time threads that run a GpioAxis' steps and inputs, and their parts, which the measurement of
// wake-up latency uses too. Tests replace the threads by a clock of their own (AxisThreads).
#pragma once

#include <pthread.h>

#include <atomic>
#include <string>
#include <vector>

#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/interface.hpp"

namespace contourd {

// A thread with SCHED_FIFO, whose stack is locked in memory. The memory that the program has at its start is
// locked too; later allocations (mainly models) are not locked, because the thread does not touch them. If
// the system refuses the priority or the lock, the thread runs without it, and refusals() says so.
class RealtimeThread {
 public:
  // Starts a thread named `name` (at most 15 letters) that runs `body(argument)`, with SCHED_FIFO `priority`
  // if that is allowed. Throws std::system_error if no thread can be created.
  RealtimeThread(const char* name, int priority, void* (*body)(void*), void* argument);
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;
  ~RealtimeThread();  // waits for the body to return

  // Returns a sentence for each request that the system refused.
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

// Waits for deadlines. A sleeping thread wakes a little late, so until() shortens the sleep by the smallest
// recent delay and polls the clock for the last microseconds.
class DeadlineWait {
 public:
  // Returns at `due`, or earlier if `interrupted()`, which is checked at least every 10 ms.
  template <typename Interrupted>
  void until(TimePoint due, Interrupted interrupted) noexcept {
    for (TimePoint now = monotonic_now(); now < due && !interrupted(); now = monotonic_now())
      sleep(now, due);
  }

 private:
  void sleep(TimePoint now, TimePoint due) noexcept;

  Duration lead_{0};
};

// Waits until each step is due, with absolute deadlines on CLOCK_MONOTONIC, and calls the engine.
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
  RealtimeThread thread_;  // last member: ends before the others are destroyed
};

// Interface of the threads of an axis. The destructor blocks until the threads have ended.
class AxisThreads : public Interface {
 public:
  // Returns a sentence for each request of the threads that the system refused.
  [[nodiscard]] virtual std::vector<std::string> refusals() const = 0;
};

// Waits for the inputs' edges and serves them.
class InputThread {
 public:
  // The inputs must outlive the thread.
  InputThread(AxisInputs& inputs, int priority);
  ~InputThread();

  [[nodiscard]] const std::vector<std::string>& refusals() const { return thread_.refusals(); }

 private:
  void run() noexcept;

  AxisInputs& inputs_;
  std::atomic<bool> quit_{false};
  RealtimeThread thread_;  // last member: ends before the others are destroyed
};

class RealtimeAxisThreads final : public AxisThreads {
 public:
  // The input thread has the higher priority, so that a switch can still halt the steps if they keep the
  // processor of both threads fully busy.
  RealtimeAxisThreads(StepEngine& engine, AxisInputs& inputs, int priority)
      : steps_(engine, priority), inputs_(inputs, priority + 1) {}

  [[nodiscard]] std::vector<std::string> refusals() const override;

 private:
  StepThread steps_;
  InputThread inputs_;
};

}  // namespace contourd
