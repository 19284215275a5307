// The threads that run an axis' steps and inputs: two real-time threads, or a test with its own clock.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/gpio/step_thread.hpp"

namespace contourd {

class AxisThreads {
 public:
  AxisThreads() = default;
  AxisThreads(const AxisThreads&) = delete;
  AxisThreads& operator=(const AxisThreads&) = delete;
  virtual ~AxisThreads() = default;  // returns when the threads have ended
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
  // The input thread has the higher priority: if both share a processor that the steps keep fully busy, a
  // switch must still halt them.
  RealtimeAxisThreads(StepEngine& engine, AxisInputs& inputs, int priority)
      : steps_(engine, priority), inputs_(inputs, priority + 1) {}

  [[nodiscard]] std::vector<std::string> refusals() const override;

 private:
  StepThread steps_;
  InputThread inputs_;
};

}  // namespace contourd
