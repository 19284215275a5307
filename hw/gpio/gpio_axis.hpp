// A Z axis of a stepper motor behind GPIO lines: step, direction, enable, limit switch and what else its
// owner has fitted. Event loop's thread only; two threads of its own make the steps and read the inputs.
//
// It has many functions, those of a ZAxis, and more members than other classes, its parts. It wires these:
// the engine and the inputs, which those threads run; where the plate is; the motor; how it comes to a
// height; homing; what its inputs' changes lead to.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/axis_drive.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/axis_interlocks.hpp"
#include "hw/gpio/axis_lines.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/gpio/axis_threads.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/homing.hpp"
#include "hw/gpio/plate_approach.hpp"
#include "hw/gpio/plate_position.hpp"
#include "hw/gpio/step_engine.hpp"
#include "hw/machine.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class GpioAxis final : public ZAxis {
 public:
  // Takes the lines and starts the threads. Clock (CLOCK_MONOTONIC's) and watcher must outlive the axis.
  // Throws HardwareError and std::system_error.
  GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config);

  // What a test puts in place of hardware and threads.
  struct Parts {
    AxisLines lines;
    StepEngine::Now now = monotonic_now;
    std::function<std::unique_ptr<AxisThreads>(StepEngine&, AxisInputs&)> start_threads;
  };
  GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config, Parts parts);
  // Motor still and disabled.
  ~GpioAxis() override;

  void home(std::function<void(HomingResult)> done) override;
  void move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void nudge(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) override;
  void stop() override;
  void abort() noexcept override;
  bool release() override;
  [[nodiscard]] bool moving() const override { return homing_.under_way() || move_done_; }
  // By the encoder where there is one, else by the steps made.
  [[nodiscard]] std::optional<Nanometers> height() const override { return position_.height(); }
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override {
    return position_.height_at(time);
  }
  [[nodiscard]] std::optional<Nanometers> homing_shift() const override { return position_.homing_shift(); }
  [[nodiscard]] Nanometers travel() const override { return config_.travel; }
  [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
    return contourd::move_duration(config_, distance, speed);
  }

  // `call` runs for every machine event from now on: for the first edge of the emergency stop, the motor
  // slowing down already, and when that lasts, with the motor still; for an open lid; for either when it is
  // over; for a switch that closes where it must not, steps that were lost, a line that cannot be set. Before
  // the `done` of a move that it ends. A move that an emergency stop has slowed down goes on when that did
  // not last.
  void on_event(std::function<void(const MachineEvent&)> call) override { on_event_ = std::move(call); }
  void set_light_cutoff(LightCutoff* cutoff) noexcept override { inputs_.set_light_cutoff(cutoff); }
  // The emergency stop, the lid.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override {
    return interlocks_.why_not_ready();
  }

  // Its chip has gone, or its lines can no longer be relied on: nothing moves any more.
  [[nodiscard]] bool lost() const override { return inputs_.lost() || drive_.line_refused(); }
  [[nodiscard]] std::string description() const override {
    return "step line " + config_.step.line + " of " + config_.step.chip;
  }
  // What the system refused the threads: priority, locked memory. None as a rule.
  [[nodiscard]] std::vector<std::string> warnings() const override { return threads_->refusals(); }
  [[nodiscard]] std::vector<AxisInputState> inputs() const override {
    return read_inputs(config_, lines_, inputs_);
  }
  [[nodiscard]] LateSteps late_steps() const override { return engine_.late_steps(); }

 private:
  [[nodiscard]] AxisDrive::Wiring drive_wiring();
  [[nodiscard]] Homing::Wiring homing_wiring();
  [[nodiscard]] AxisInterlocks::Wiring interlocks_wiring();
  void inputs_changed();
  [[nodiscard]] bool takes_contact(const InputChange& change);
  [[nodiscard]] bool take_contact();
  void end_move(MoveResult result);
  void fail(const AxisFault& fault);
  void report(const MachineEvent& event);

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
  std::function<void(MoveResult)> move_done_;
  bool nudged_ = false, nudge_met_switch_ = false;  // by the motion under way
  std::unique_ptr<DescriptorWatcher::Watch> watch_end_, watch_inputs_;
  std::unique_ptr<AxisThreads> threads_;  // last: they use the others
};

}  // namespace contourd
