// What runs an axis' steps and inputs: two real-time threads, or a test under its own time.
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
  virtual ~AxisThreads() = default;  // what they run has ended by then

  // A sentence for each thing that the system refused them.
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
  RealtimeThread thread_;  // last: runs while the others are there
};

class RealtimeAxisThreads final : public AxisThreads {
 public:
  // The one that reads goes before the one that makes steps: where they share a processor that has no time
  // left besides the steps, a switch must halt them all the same.
  RealtimeAxisThreads(StepEngine& engine, AxisInputs& inputs, int priority)
      : steps_(engine, priority), inputs_(inputs, priority + 1) {}

  [[nodiscard]] std::vector<std::string> refusals() const override;

 private:
  StepThread steps_;
  InputThread inputs_;
};

}  // namespace contourd
