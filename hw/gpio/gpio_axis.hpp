// A Z axis of a stepper motor behind GPIO lines: step, direction, enable, limit switch and what else its
// owner has fitted. Event loop's thread only; two threads of its own make the steps and read the inputs.
//
// Homing: towards the limit switch at homing speed; 5 mm back; towards it again at half the speed. At the
// switch's first edge the reading thread halts the steps: the motor goes on for as many steps as fall between
// the kernel's time stamp of the edge and that thread's waking, one as a rule at 4,000 steps/s. The position
// is exact all the same: the step count at the time stamp. Then the plate moves to the switch's height.
//
// What the time stamp cannot tell: an edge while a step is being made, from the look at the clock to the
// level on the line, is one of two steps. And the kernel keeps a line's last edge only until its thread for
// the interrupt has run: of a contact that bounces sooner, the first edge is lost. On one processor no step
// is made meanwhile, since the threads go before the steps; with more of them, as many as fall within.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hw/descriptor_watcher.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/axis_lines.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/gpio/axis_threads.hpp"
#include "hw/gpio/encoder_plausibility.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/screw.hpp"
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
  void stop() override;
  void abort() noexcept override;
  [[nodiscard]] bool moving() const override { return homing_done_ || move_done_; }
  // By the encoder where there is one, else by the steps made.
  [[nodiscard]] std::optional<Nanometers> height() const override;
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const override;
  [[nodiscard]] Nanometers travel() const override { return config_.travel; }
  [[nodiscard]] Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const override {
    return contourd::move_duration(config_, distance, speed);
  }

  // `call` runs for every disturbance from now on: for the first edge of the emergency stop, the motor
  // slowing down already, and when that lasts, with the motor still; for an open lid; for either when it is
  // over; for a switch that closes where it must not, steps that were lost, a line that cannot be set. Before
  // the `done` of a move that it ends. A move that an emergency stop has slowed down goes on when that did
  // not last.
  void on_disturbance(std::function<void(const Disturbance&)> call) override { disturbed_ = std::move(call); }
  void set_light_cutoff(LightCutoff* cutoff) noexcept override { inputs_.set_light_cutoff(cutoff); }
  // The emergency stop, the lid.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;

  // Its chip has gone, or its lines can no longer be relied on: nothing moves any more.
  [[nodiscard]] bool lost() const override { return inputs_.lost() || line_refused_; }
  [[nodiscard]] std::string description() const override {
    return "step line " + config_.step.line + " of " + config_.step.chip;
  }
  // What the system refused the threads: priority, locked memory. None as a rule.
  [[nodiscard]] std::vector<std::string> warnings() const override { return threads_->refusals(); }
  [[nodiscard]] LateSteps late_steps() const override { return engine_.late_steps(); }
  // Edges of the encoder that were missed or made up by noise.
  [[nodiscard]] std::uint64_t illegal_encoder_edges() const { return inputs_.illegal_encoder_edges(); }

 private:
  enum class Way { Move, Seek, BackOff };
  // What ended a run that was halted.
  struct Trip {
    HomingResult homing;
    std::string what;
    bool emergency_stop = false;
  };
  // The run under way.
  struct Run {
    Way way;
    std::int64_t target;
    MillimetersPerSecond speed;
  };
  // A run towards the limit switch.
  struct Seek {
    std::int64_t last;  // position at which it is given up
    MillimetersPerSecond speed;
    std::function<void(std::optional<TimePoint>)> found;  // when it closed; nothing when it was closed before
    std::optional<InputChange> contact;                   // what the contact came to
  };

  // Steps.
  void when_ready(std::function<void()> call);
  void run(Way way, std::int64_t steps, MillimetersPerSecond speed, std::function<void()> then);
  void run_on();
  void go_on();
  void set_rules(Way way, bool towards_switch);
  void run_ended();
  void take_end();
  void tell_stall();
  void after(Duration wait, std::function<void()> call);
  void inputs_changed();
  void take_change(const InputChange& change);
  void take_emergency_stop(const InputChange& change);
  void take_lid(const InputChange& change);
  void take_limit_switch(const InputChange& change);
  void blocked();
  [[nodiscard]] std::string loss() const;
  [[nodiscard]] std::string where() const;  // " at 12.345 mm"; empty where that is unknown

  // Moves.
  void approach(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> then);
  void begin_approach(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> there);

  // Homing.
  void seek(MillimetersPerSecond speed, std::int64_t steps,
            std::function<void(std::optional<TimePoint>)> found);
  void seek_further();
  void seek_on();
  void back_off(std::function<void()> then);
  void take_position(TimePoint edge);

  // Endings.
  void end_homing(HomingResult result);
  void end_move(MoveResult result);
  void end_stopped();
  void fail(const Trip& trip);
  void disturb(Disturbance::Kind kind, const std::string& what, bool owner_decides = false);
  void forget() noexcept;

  // Encoder.
  [[nodiscard]] std::int64_t counts() const;
  [[nodiscard]] double measured_plate() const;
  [[nodiscard]] double encoder_off_mm() const;
  void agree();
  void begin_following();
  void follow();
  void verify(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> then);
  [[nodiscard]] std::optional<std::string> encoder_doubt();
  [[nodiscard]] std::string difference() const;

  [[nodiscard]] Screw::Rest now_at() const { return screw_.moved(rest_, engine_.position()); }
  [[nodiscard]] double pull_in() const;
  [[nodiscard]] std::string stall_words() const;
  [[nodiscard]] std::int64_t towards_switch() const { return config_.homes_upwards ? 1 : -1; }

  Clock& clock_;
  GpioAxisConfig config_;
  Screw screw_;
  AxisLines lines_;
  StepEngine engine_;
  AxisInputs inputs_;
  std::function<void(const Disturbance&)> disturbed_;

  bool enabled_ = false, position_known_ = false, stop_wanted_ = false;
  bool running_ = false;        // a run is under way, its end not taken yet
  std::optional<StepEnd> end_;  // how it ended, until something has come of it
  std::uint64_t stalls_told_ = 0;
  bool emergency_told_ = false, loss_told_ = false, line_refused_ = false;
  Screw::Rest rest_;  // before the run under way
  std::function<void(HomingResult)> homing_done_;
  std::function<void(MoveResult)> move_done_;
  std::function<void()> then_;  // behind the run under way
  Run run_{};
  // Waits until a halted run has come to its end, and until it is known whether the emergency stop is
  // pressed.
  std::function<void()> ready_;
  std::optional<Seek> seek_;
  std::optional<Trip> trip_;
  // Where the encoder and the steps agreed.
  double counts_then_ = 0;
  std::int64_t plate_then_ = 0;
  std::optional<EncoderPlausibility> plausibility_;
  std::uint64_t index_pulses_seen_ = 0;
  std::unique_ptr<Timer> wait_, following_;
  std::unique_ptr<DescriptorWatcher::Watch> watch_end_, watch_inputs_;
  std::unique_ptr<AxisThreads> threads_;  // last: they use the others
};

}  // namespace contourd
