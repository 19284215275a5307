// An axis' motor, as its owner moves it: enabled before its first step, in runs from rest to rest, halted by
// the switches where they should not close, watched by the encoder while it turns. A run that an emergency
// stop has slowed down goes on when that did not last. All that is handed over must outlive it. Event loop's
// thread only.
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
  // What the limit switch may do meanwhile.
  enum class RunKind {
    Move,     // close where it should: elsewhere it halts the run
    Seek,     // its first edge halts the run
    BackOff,  // anything
  };

  // Who is told what. Each may end or begin a motion.
  struct Wiring {
    std::function<void(const AxisFault&)> fail;
    std::function<void(const std::string&)> notice;
    std::function<void()> stopped;  // as stop() asked for
    std::function<void()> blocked;  // the steps are inhibited
    // A run has ended. What has halted it is among the inputs' changes; the limit switch's contact that has
    // is taken last: whether there is one.
    std::function<void()> take_changes;
    std::function<bool()> take_contact;
  };

  // `enable` may be null: there is none.
  AxisDrive(Clock& clock, const GpioAxisConfig& config, OutputLine* enable, StepEngine& engine,
            AxisInputs& inputs, PlatePosition& position, Wiring wiring);

  // A motion, which lasts until forget(). Calls `ready` when the motor may turn.
  void begin(std::function<void()> ready);
  // Runs so many steps, then calls `then`, unless it ends otherwise.
  void run(RunKind kind, Microsteps steps, MillimetersPerSecond speed, std::function<void()> then);
  // What is left of the last run.
  void run_on();
  // The motor without current, where a line does that; false where none does. Where the plate is nobody knows
  // then. REQUIRES: no motion.
  bool release();
  // What is left of the run is not run: it ended where it should.
  void end_run();
  // Between runs; in place of what waits already.
  void after(Duration wait, std::function<void()> call);

  // Slows the motion down to rest, for good.
  void stop();
  // Until the emergency stop is known not to be pressed.
  void slow_down();
  // The run was halted for this.
  void halted_for(AxisFault cause) { run_.cause = std::move(cause); }
  // No further step, and where the plate is nobody knows.
  void halt() noexcept;
  // The motion is over; what waits is dropped.
  void forget() noexcept;

  // The engine's ended() is readable.
  void engine_ended();
  // What waits for the motor to rest, or for the emergency stop, looks again.
  void go_on();

  // A run is under kind, or nothing has come of its end yet.
  [[nodiscard]] bool turning() const noexcept { return engine_.moving() || run_.turning || run_.end; }
  // Looks whether the encoder can be believed, and tells. False also when who was told has ended the motion.
  [[nodiscard]] bool encoder_is_believed();
  // A line could not be set.
  [[nodiscard]] bool line_refused() const noexcept { return line_refused_; }

 private:
  enum class Wanted { Nothing, Motion, Rest };
  struct Run {
    RunKind kind = RunKind::Move;
    Microsteps target{};
    MillimetersPerSecond speed{0};
    std::function<void()> then;
    bool turning = false;              // its end is not taken yet
    std::optional<StepEnd> end{};      // how it ended, until something has come of it
    std::optional<AxisFault> cause{};  // of a halt
  };

  void when_ready(std::function<void()> call);
  void set_rules(bool towards_switch);
  void drop_rules() noexcept;
  void take_end();
  void fail_stalled();
  void tell_stall();
  [[nodiscard]] std::string stall_words() const;
  [[nodiscard]] double pull_in() const;
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
  std::uint64_t stalls_told_ = 0;
  Run run_;
  // Waits until a halted run has come to its end, and until it is known whether the emergency stop is
  // pressed.
  std::function<void()> ready_;
  std::unique_ptr<Timer> wait_, following_;
};

}  // namespace contourd
