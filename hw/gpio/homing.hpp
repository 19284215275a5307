// The axis' homing: looks up each event in the table of homing_states.hpp and carries out the effects of its
// row. Event loop's thread only.
//
// At the switch's first edge the input thread halts the steps. The motor still makes the steps that fall
// between the kernel's time stamp of the edge and the wake-up of that thread, usually one at 4,000 steps/s.
// The position is exact nevertheless, because it is the step count at the time stamp. Then the plate moves to
// the switch's height.
//
// The time stamp has two limits. An edge while a step is being made, between reading the clock and setting
// the line, can belong to either of two steps. And the kernel keeps only a line's last edge until its
// interrupt thread has run, so the first edge of a contact that bounces faster is lost. On one processor no
// step is made in that time, since the interrupt thread has priority; on several processors the error is the
// steps made in that time.
#pragma once

#include <functional>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/gpio/axis_drive.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/homing_states.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

class Homing {
 public:
  using Done = std::function<void(HomingResult)>;
  using Call = std::function<void()>;

  // The actions of the axis. Those that begin something return before it is over.
  struct Wiring {
    std::function<void()> forget_position;
    std::function<void(Call ready)> get_ready;
    std::function<bool()> switch_closed;  // the settled state
    // Runs this far towards the switch; away from it if the distance is negative.
    std::function<void(AxisDrive::RunKind, Nanometers, MillimetersPerSecond, Call over)> run;
    std::function<void()> run_on;   // makes the remaining steps of the run
    std::function<void()> end_run;  // drops the remaining steps of the run
    std::function<bool()> turning;
    std::function<void(Duration, Call)> after;
    std::function<void(TimePoint edge)> take_position;
    std::function<void()> know_position;
    std::function<void(Call there)> approach;  // moves to the switch's height
    std::function<void()> stop;                // stopped() is called when the motor rests
    std::function<void()> forget;              // ends the motion and drops its pending calls
  };

  Homing(const GpioAxisConfig& config, Wiring wiring);

  // REQUIRES: !under_way().
  void begin(Done done);
  [[nodiscard]] bool under_way() const { return state_ != HomingState::Idle; }

  // True during a pass, in which contact() must be called for the limit switch's contact.
  [[nodiscard]] bool in_pass() const { return is_in_pass(state_); }
  // Takes the settled contact, closed or open, that halted a pass. It is handled when the motor rests.
  void contact(const InputChange& change);
  // To be called when the motor rests. Handles the contact; false if none has come.
  bool take_contact();

  void stop() { take(HomingEvent::StopWanted); }
  void stopped() { take(HomingEvent::Stopped); }
  // Ends homing after a fault, which the caller has reported, or because of resistance. The motor rests.
  void failed(HomingResult result);
  // Ends homing without calling `done`.
  void abort() { take(HomingEvent::Aborted); }

 private:
  void take(HomingEvent event);
  void carry_out(HomingEffect effect);
  void seek(Nanometers distance, MillimetersPerSecond speed) {
    wiring_.run(AxisDrive::RunKind::Seek, distance, speed, [this] { way_over(); });
  }
  void way_over() { take(HomingEvent::WayOver); }
  void look_at_switch() {
    take(wiring_.switch_closed() ? HomingEvent::SwitchClosed : HomingEvent::SwitchOpen);
  }
  void wait(Duration time) {
    wiring_.after(time, [this] { take(HomingEvent::WaitOver); });
  }
  void finish(HomingResult result);

  const GpioAxisConfig& config_;
  const Wiring wiring_;
  HomingState state_ = HomingState::Idle;
  Done done_;
  std::optional<InputChange> contact_;  // kept until the motor rests
  TimePoint edge_{};                    // the time of the last contact's first edge
  HomingResult failure_ = HomingResult::Fault;
};

}  // namespace contourd
