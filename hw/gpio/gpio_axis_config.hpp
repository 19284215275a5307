// What a stepped Z axis is made of, as its owner describes it. Value types.
#pragma once

#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/gpio/gpio_line_config.hpp"

namespace contourd {

// How a contact stands at rest: switch not reached, stop not pressed, lid closed. A normally closed one has
// its line at the active level then, and a broken wire is as if it were not at rest.
enum class Contact { NormallyOpen, NormallyClosed };

struct GpioInputConfig {
  GpioLineConfig line;  // active is: the contact conducts
  LineBias bias = LineBias::AsIs;
  Duration debounce{std::chrono::milliseconds{5}};  // a level counts when it has lasted this long
  Contact contact = Contact::NormallyOpen;

  // The line as it is taken: active is switch reached, stop pressed, lid open.
  [[nodiscard]] GpioLineConfig logical_line() const {
    GpioLineConfig logical = line;
    logical.active_low = line.active_low != (contact == Contact::NormallyClosed);
    return logical;
  }
};

struct EncoderConfig {
  GpioLineConfig a, b;
  LineBias bias = LineBias::AsIs;
  double counts_per_mm = 0;      // quadrature counts: four a line of the scale
  bool reversed = false;         // counts down as the plate rises
  Nanometers tolerance{50'000};  // a difference from the steps up to this is no difference

  enum class Policy { Fault, Correct };
  Policy policy = Policy::Fault;  // what a difference beyond it is: a fault, or made good by further steps
  // What is made good at most: in one move, and in all since homing. More is a fault.
  Nanometers most_correction{250'000}, most_correction_sum{500'000};

  std::optional<GpioLineConfig> index;  // its mark: active once every `index_every`
  Nanometers index_every{0};
};

// Of any move. A thread takes about as long as an interval of 50 us to wake: beyond, it would never sleep,
// and the kernel, which leaves real-time threads 95 % of the time, would hold it up for 50 ms in every
// second.
inline constexpr double kMaxStepsPerSecond = 20'000;

// As many as pulses of this width, and pauses as long, leave room for: an interval becomes as short as three
// quarters behind a late step.
[[nodiscard]] constexpr double most_steps_per_second(std::chrono::duration<double> pulse_width) {
  return 0.75 / (2 * pulse_width.count());
}

struct GpioAxisConfig {
  Nanometers travel{160'000'000};  // highest height of a move
  double microsteps_per_mm = 800.0;
  // Of homing's first pass; the second is half as fast. At the switch the motor stops dead: keep it below the
  // speed from which the motor can do that without losing steps. Half of it counts as the motor's pull-in
  // speed: held up above that, it may have lost steps.
  MillimetersPerSecond homing_speed{5.0};
  MillimetersPerSecond top_speed{10.0};  // of any move
  MillimetersPerSecondSquared acceleration{25.0};
  std::optional<double> jerk_mm_s3;  // S-curve; a trapezoid without it
  Nanometers backlash{0};            // moves downwards go this much too far and come back up
  // Height of the plate where the limit switch closes, by the homing's second pass.
  Nanometers switch_height{0};
  bool homes_upwards = false;  // the limit switch is at the top

  GpioLineConfig step, direction;  // direction active: the plate rises
  std::optional<GpioLineConfig> enable;
  Duration enable_settle{std::chrono::milliseconds{10}};  // from enabling the motor to its first step
  Duration pulse_width{2'000};      // of the step line's active level, at least; its pause likewise
  Duration direction_setup{5'000};  // from a change of direction to the next step, at least

  GpioInputConfig limit_switch;
  std::optional<GpioInputConfig> second_switch;  // at the other end: reached in a move it is a fault
  std::optional<EncoderConfig> encoder;
  std::optional<GpioInputConfig> emergency_stop, lid;

  // SCHED_FIFO, of the thread that makes the steps; the one that reads the inputs has one more. Below that of
  // the kernel's threads for interrupts, 50, and 49 where it has two for a line: an edge's time is kept until
  // its thread has run, and only the last edge's. Refused by the system, the axis works and says so.
  int realtime_priority = 40;
};

}  // namespace contourd
