// A Z axis with a stepper motor on GPIO lines: step, direction, limit switch, and optionally enable, second
// switch, encoder, emergency stop, lid, power fail and force. Event loop's thread only; two threads of its
// own make the steps and read the inputs.
//
// Connects the axis' parts: the step engine and the inputs, which the two threads run; the plate's position;
// the motor; the approach to a height; homing; and the reactions to the inputs' changes.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/axis_drive.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/axis_interlocks.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/gpio/axis_threads.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/homing.hpp"
#include "hw/gpio/plate_approach.hpp"
#include "hw/gpio/plate_position.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/machine.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

// Returns a sentence about figures in the config that contradict each other, or nullopt if they are
// consistent.
[[nodiscard]] std::optional<std::string> contradiction(const GpioAxisConfig& config);

// The lines of an axis; a line that the config does not name is null.
struct AxisLines {
  std::unique_ptr<OutputLine> step, direction, enable;
  std::array<std::unique_ptr<InputLine>, kAxisInputs> inputs;  // by AxisInput
  std::unique_ptr<InputLine> encoder_a, encoder_b, encoder_index;
};

class GpioAxis final : public ZAxis {
 public:
  // Takes the lines and starts the threads. The clock (CLOCK_MONOTONIC) and the watcher must outlive the
  // axis. Throws HardwareError and std::system_error.
  GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config);

  // Hardware and threads, which a test replaces.
  struct Parts {
    AxisLines lines;
    StepEngine::Now now = monotonic_now;
    std::function<std::unique_ptr<AxisThreads>(StepEngine&, AxisInputs&)> start_threads;
  };
  GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config, Parts parts);
  // Stops the motor and disables it.
  ~GpioAxis() override { engine_.inhibit(); }

  void home(std::function<void(HomingResult)> done) override;
  void move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void rise(const RisePlan& plan, std::function<void(MoveResult)> done) override;
  void nudge(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void raise(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void assume_height(Nanometers height) override;
  [[nodiscard]] bool homes_upwards() const override { return config_.homes_upwards; }
  void expect_contact_at(Nanometers height) override { position_.expect_contact_at(height); }
  [[nodiscard]] std::optional<bool> force() const override {
    return config_.force ? std::optional(inputs_.active(AxisInput::Force)) : std::nullopt;
  }
  void on_force(std::function<void(const ForceChange&)> call) override { on_force_ = std::move(call); }
  void stop() override;
  void abort() noexcept override;
  bool release() override;
  [[nodiscard]] bool moving() const override { return homing_.under_way() || move_done_; }
  // Returns the height by the encoder if there is one, else by the steps made.
  [[nodiscard]] std::optional<Nanometers> height() const override { return position_.height(); }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override {
    return position_.height_at(time);
  }
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return position_.homing_shift(); }
  [[nodiscard]] Nanometers travel() const override { return config_.travel; }
  [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
    return contourd::move_duration(config_, distance, speed);
  }

  // Sets the callback for all machine events: the first edge of the emergency stop (the motor is slowing down
  // already), an emergency stop that lasts (the motor has stopped), an open lid, the end of either, a switch
  // that closes in the wrong place, lost steps, a line that cannot be set. It runs before the `done` of a
  // move that the event ends. A move that was slowed down by an emergency stop continues if the stop did not
  // last.
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  void set_light_cutoff(LightCutoff* cutoff) noexcept override { inputs_.set_light_cutoff(cutoff); }
  // Returns a sentence each for the emergency stop and the lid if they are not safe.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    return interlocks_.why_not_ready();
  }

  // True if the lines' chip is gone or the lines can no longer be relied on; the axis does not move any more.
  [[nodiscard]] bool lost() const override { return inputs_.lost() || drive_.line_refused(); }
  [[nodiscard]] std::string description() const override {
    return "step line " + config_.step.line + " of " + config_.step.chip;
  }
  // Returns a sentence for each request of the threads that the system refused: priority, locked memory.
  [[nodiscard]] std::vector<std::string> warnings() const override { return threads_->refusals(); }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override;
  [[nodiscard]] LateSteps late_steps() const override { return engine_.late_steps(); }

 private:
  void move_unhomed(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done);
  [[nodiscard]] AxisDrive::Wiring drive_wiring();
  [[nodiscard]] Homing::Wiring homing_wiring();
  [[nodiscard]] AxisInterlocks::Wiring interlocks_wiring();
  [[nodiscard]] std::optional<MoveResult> why_not(const RisePlan& plan) const;
  void follow(const RisePlan& plan);
  void inputs_changed();
  [[nodiscard]] bool takes_contact(const InputChange& change);
  [[nodiscard]] bool take_contact();
  void end_move(MoveResult result);
  void force_changed(const InputChange& change);
  void resisted();
  void fail(const AxisFault& fault);
  void report(const MachineEvent& event) {
    if (on_event_) on_event_(event);
  }

  const GpioAxisConfig config_;
  AxisLines lines_;
  StepEngine engine_;
  AxisInputs inputs_;
  PlatePosition position_;
  AxisDrive drive_;
  PlateApproach approach_;
  Homing homing_;
  AxisInterlocks interlocks_;
  std::function<void(const MachineEvent&)> on_event_;
  std::function<void(const ForceChange&)> on_force_;
  std::function<void(MoveResult)> move_done_;
  bool nudged_ = false, nudge_met_switch_ = false;  // for the present motion
  std::unique_ptr<DescriptorWatcher::Watch> watch_end_, watch_inputs_;
  std::unique_ptr<AxisThreads> threads_;  // last member: the threads use the others
};

}  // namespace contourd
