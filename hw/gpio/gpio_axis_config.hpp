// The config of a stepped Z axis. Value types.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct GpioLineConfig {
  std::string chip = "gpiochip0";  // device name below /dev, a path, or the chip's label ("pinctrl-bcm2711")
  std::string line;                // its number on that chip ("17"), or its name ("GPIO17")
  bool active_low = false;         // "on", "closed", "enabled" is the low level
};

enum class LineBias { AsIs, PullUp, PullDown, Off };

// The state of a contact at rest: switch not reached, stop not pressed, lid closed, power good, no force. At
// rest the line of a normally closed contact has its active level, so a broken wire looks like a contact that
// is not at rest.
enum class Contact { NormallyOpen, NormallyClosed };

struct GpioInputConfig {
  GpioLineConfig line;  // active: the contact conducts
  LineBias bias = LineBias::AsIs;
  Duration debounce{std::chrono::milliseconds{5}};  // a level counts when it has lasted this long
  Contact contact = Contact::NormallyOpen;

  // Returns the line as it is requested: active means switch reached, stop pressed, lid open, power failing,
  // force.
  [[nodiscard]] GpioLineConfig logical_line() const {
    GpioLineConfig logical = line;
    logical.active_low = line.active_low != (contact == Contact::NormallyClosed);
    return logical;
  }
};

// A line of a comparator that is active while the force on the plate, or on the vat, exceeds its threshold:
// up or down, as the plate peels a layer off or presses on something.
struct ForceConfig {
  GpioInputConfig input;  // active: the force exceeds the threshold
  // Distance above the film, for the plate or the part on it, within which a force on the way down is that of
  // the resin which is pressed out. A force further up is resistance.
  Nanometers contact_from{2'000'000};
};

struct EncoderConfig {
  GpioLineConfig a, b;
  LineBias bias = LineBias::AsIs;
  double counts_per_mm = 0;      // quadrature counts: four per line of the scale
  bool reversed = false;         // the count falls as the plate rises
  Nanometers tolerance{50'000};  // up to this difference encoder and steps count as equal

  enum class Policy { Fault, Correct };
  Policy policy = Policy::Fault;  // a larger difference is a fault, or is corrected by further steps
  // The largest correction in one move, and in all moves since homing. More is a fault.
  Nanometers most_correction{250'000}, most_correction_sum{500'000};

  std::optional<GpioLineConfig> index;  // the index mark's line: active once every `index_every`
  Nanometers index_every{0};
};

// The highest step rate of any move. A thread takes about 50 us to wake up. At shorter intervals the step
// thread would never sleep, and the kernel, which gives real-time threads 95 % of the time, would stop it for
// 50 ms in every second.
inline constexpr double kMaxStepsPerSecond = 20'000;

// Returns the highest step rate at which pulses of this width and equally long pauses fit into an interval.
// After a late step an interval shrinks to three quarters.
[[nodiscard]] constexpr double most_steps_per_second(std::chrono::duration<double> pulse_width) {
  return 0.75 / (2 * pulse_width.count());
}

struct GpioAxisConfig {
  Nanometers travel{160'000'000};  // highest height of a move
  double microsteps_per_mm = 800.0;
  // The speed of homing's first pass; the second is half as fast. At the switch the motor stops dead, so this
  // must be a speed from which it can do so without losing steps. Half of it is taken for the motor's pull-in
  // speed: a motor that is delayed above that speed may have lost steps.
  MillimetersPerSecond homing_speed{5.0};
  MillimetersPerSecond top_speed{10.0};  // limit for all moves
  MillimetersPerSecondSquared acceleration{25.0};
  std::optional<double> jerk_mm_s3;  // S-curve; a trapezoid if unset
  Nanometers backlash{0};            // moves downwards go this much too far and come back up
  // The height of the plate at which the limit switch closes in homing's second pass.
  Nanometers switch_height{0};
  bool homes_upwards = false;  // the limit switch is at the top

  GpioLineConfig step, direction;  // direction active: the plate rises
  std::optional<GpioLineConfig> enable;
  Duration enable_settle{std::chrono::milliseconds{10}};  // from enabling the motor to its first step
  Duration pulse_width{2'000};      // minimum of a step pulse, and of the pause after it
  Duration direction_setup{5'000};  // minimum from a change of direction to the next step

  GpioInputConfig limit_switch;
  std::optional<GpioInputConfig> second_switch;  // at the other end; a fault if a move reaches it
  std::optional<EncoderConfig> encoder;
  std::optional<GpioInputConfig> emergency_stop, lid;
  // Active while the supply fails, from a UPS or a comparator: interrupts the print as the lid does.
  std::optional<GpioInputConfig> power_fail;
  std::optional<ForceConfig> force;  // stops moves down that meet resistance

  // The SCHED_FIFO priority of the step thread; the input thread has one more. It must be below that of the
  // kernel's interrupt threads, 50, and 49 where the kernel has two for a line: until such a thread has run,
  // the kernel keeps only the last edge's time. If the system refuses the priority, the axis works and
  // reports that.
  int realtime_priority = 40;
};

}  // namespace contourd
