// The axis' homing: takes what happens through the table of homing_states.hpp and does what its rows say.
// Event loop's thread only.
//
// At the switch's first edge the reading thread halts the steps: the motor goes on for as many steps as fall
// between the kernel's time stamp of the edge and that thread's waking, one as a rule at 4,000 steps/s. The
// position is exact all the same: the step count at the time stamp. Then the plate moves to the switch's
// height.
//
// What the time stamp cannot tell: an edge while a step is being made, from the look at the clock to the
// level on the line, is one of two steps. And the kernel keeps a line's last edge only until its thread for
// the interrupt has run: of a contact that bounces sooner, the first edge is lost. On one processor no step
// is made meanwhile, since the threads go before the steps; with more of them, as many as fall within.
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

  // What it has the axis do. All but switch_closed return before what they begin is over.
  struct Wiring {
    std::function<void()> forget_position;
    std::function<void(Call ready)> get_ready;
    std::function<bool()> switch_closed;  // once settled
    // So far towards the switch; less than nothing: away from it.
    std::function<void(AxisDrive::RunKind, Nanometers, MillimetersPerSecond, Call over)> run;
    std::function<void()> run_on;   // what is left of it, if anything
    std::function<void()> end_run;  // none of that
    std::function<bool()> turning;
    std::function<void(Duration, Call)> after;
    std::function<void(TimePoint edge)> take_position;
    std::function<void()> know_position;
    std::function<void(Call there)> approach;  // to the switch's height
    std::function<void()> stop;                // ends in stopped()
    std::function<void()> forget;              // all of these that have begun
  };

  Homing(const GpioAxisConfig& config, Wiring wiring);

  // REQUIRES: !under_way().
  void begin(Done done);
  [[nodiscard]] bool under_way() const { return state_ != HomingState::Idle; }

  // Whether the limit switch's contact is its own, so that contact() is to hear of it.
  [[nodiscard]] bool in_pass() const { return is_in_pass(state_); }
  // The contact that halts a pass has settled, closed or open. It counts when the motor rests.
  void contact(const InputChange& change);
  // The motor does: whether a contact has come meanwhile.
  bool take_contact();

  void stop() { take(HomingEvent::StopWanted); }
  void stopped() { take(HomingEvent::Stopped); }
  // Whoever found the fault has told it, and halted the motor.
  void failed(HomingResult result);
  // Nobody is answered.
  void abort() { take(HomingEvent::Aborted); }

 private:
  void take(HomingEvent event);
  void carry_out(HomingEffect effect);
  void seek(Nanometers distance, MillimetersPerSecond speed);
  void way_over() { take(HomingEvent::WayOver); }
  void look_at_switch();
  void wait(Duration time);
  void finish(HomingResult result);

  const GpioAxisConfig& config_;
  const Wiring wiring_;
  HomingState state_ = HomingState::Idle;
  Done done_;
  std::optional<InputChange> contact_;  // while the motor turns
  TimePoint edge_{};                    // of the last contact
  HomingResult failure_ = HomingResult::Fault;
};

}  // namespace contourd
