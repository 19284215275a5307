// The motor of an axis: it is enabled before its first step, moves in runs from rest to rest, is halted by a
// switch that closes in the wrong place, and is checked by the encoder while it turns. A run that was slowed
// down by a short disturbance of the emergency stop continues. All constructor arguments must outlive this
// object. Event loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hw/clock.hpp"
#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/plate_position.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {

class AxisDrive {
 public:
  // The effect of the limit switch on a run. Force stops a run down: in a Move above the height at which
  // contact is expected, in a Seek once the plate has moved on under it, in a Nudge at once.
  enum class RunKind {
    Move,     // halts the run if it closes anywhere but at its height
    Seek,     // halts the run at its first edge
    Nudge,    // halts the run at its first edge; the plate's position is unknown and stays so
    BackOff,  // none
  };

  // Callbacks. Each may end or begin a motion.
  struct Wiring {
    std::function<void(const AxisFault&)> fail;
    std::function<void(const std::string&)> notice;
    std::function<void()> stopped;  // the motor rests after stop()
    std::function<void()> blocked;  // the steps are inhibited
    // Both are called after a run has ended. take_changes handles the inputs' changes, which contain the
    // cause of a halt. Then take_contact handles a limit switch's contact that halted the run; true if there
    // was one.
    std::function<void()> take_changes;
    std::function<bool()> take_contact;
    std::function<void()> resisted;  // a run down met resistance, and the motor rests
  };

  // `enable` is null if the motor has no enable line.
  AxisDrive(Clock& clock, const GpioAxisConfig& config, OutputLine* enable, StepEngine& engine,
            AxisInputs& inputs, PlatePosition& position, Wiring wiring);

  // Begins a motion, which lasts until forget(). Calls `ready` when the motor may turn.
  void begin(std::function<void()> ready);
  // Makes `steps` steps, then calls `then`, unless the run ends early.
  void run(RunKind kind, Microsteps steps, MillimetersPerSecond speed, std::function<void()> then);
  // Makes `steps` steps upwards along a rise, then calls `then`, unless the run ends early. A rise that was
  // slowed down does not continue: it ends as after stop().
  void rise(std::shared_ptr<const RiseCurve> rise, Microsteps steps, std::function<void()> then);
  // Makes the remaining steps of the last run.
  void run_on();
  // Switches the motor's current off by the enable line; the plate's position is unknown then. Returns false
  // if there is no enable line or it could not be set. REQUIRES: the motor rests.
  bool release();
  // Drops the remaining steps: the run ended where it should.
  void end_run();
  // Calls `call` after the wait; for use between runs. Replaces an earlier wait.
  void after(Duration wait, std::function<void()> call) { wait_ = clock_.call_after(wait, std::move(call)); }

  // Slows the motion down to rest and ends it.
  void stop();
  // Slows the run down to rest until it is known that the emergency stop is not pressed.
  void slow_down() {
    if (run_.turning) engine_.stop();
  }
  // Sets the fault that this run, which was halted, ends with; with HomingResult::Resistance it is none, and
  // the run ends with Wiring::resisted.
  void halted_for(AxisFault cause) { run_.cause = std::move(cause); }
  // Makes no further step and forgets the plate's position.
  void halt() noexcept;
  // Ends the motion and drops pending calls.
  void forget() noexcept;

  // To be called when the engine's ended() is readable.
  void engine_ended();
  // Retries a call that waits for the motor to rest or for the emergency stop to settle.
  void go_on();

  // True during a run, and until its end has been handled.
  [[nodiscard]] bool turning() const noexcept { return engine_.moving() || run_.turning || run_.end; }
  // Checks that the encoder is plausible and reports it if not. False also if a callback has ended the
  // motion.
  [[nodiscard]] bool encoder_is_believed();
  // True if the kernel has refused to set a line.
  [[nodiscard]] bool line_refused() const noexcept { return line_refused_; }

 private:
  enum class Wanted { Nothing, Motion, Rest };
  struct Run {
    RunKind kind = RunKind::Move;
    Microsteps target{};
    MillimetersPerSecond speed{0};
    std::function<void()> then;
    std::shared_ptr<const RiseCurve> rise{};
    bool turning = false;              // until engine_ended()
    std::optional<StepEnd> end{};      // how the run ended, until that has been handled
    std::optional<AxisFault> cause{};  // the cause of a halt
  };

  void when_ready(std::function<void()> call);
  void set_rules(bool towards_switch);
  void drop_rules() noexcept;
  void take_end();
  void fail_stalled();
  void report_stall();
  [[nodiscard]] std::string stall_text() const;
  void follow();

  Clock& clock_;
  const GpioAxisConfig& config_;
  OutputLine* enable_;
  StepEngine& engine_;
  AxisInputs& inputs_;
  PlatePosition& position_;
  Wiring wiring_;

  Wanted wanted_ = Wanted::Nothing;
  bool enabled_ = false, line_refused_ = false;
  std::uint64_t stalls_reported_ = 0;
  Run run_;
  // The call that waits until a halted run has ended, or until it is known whether the emergency stop is
  // pressed.
  std::function<void()> ready_;
  std::unique_ptr<Timer> wait_, following_;
};

}  // namespace contourd
