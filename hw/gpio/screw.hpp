// The screw between motor and plate. It moves in whole microsteps and has backlash: when the motor turns
// downwards the plate follows later. Positions are in microsteps. Pure value.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/geometry/units.hpp"

namespace contourd {

class Screw {
 public:
  Screw(double microsteps_per_mm, Nanometers backlash)
      : per_mm_(microsteps_per_mm), backlash_(nearest_step(backlash)) {}

  [[nodiscard]] double microsteps_per_mm() const { return per_mm_; }
  [[nodiscard]] Microsteps backlash() const { return backlash_; }

  [[nodiscard]] Microsteps nearest_step(Nanometers height) const {
    return Microsteps{std::llround(to_millimeters(height).count() * per_mm_)};
  }
  [[nodiscard]] Nanometers height(double steps) const {
    return Nanometers{std::llround(steps / per_mm_ * 1e6)};
  }

  // A position from which the motor moves in one direction: the motor is at `motor`, the plate `play` above
  // it.
  struct Rest {
    Microsteps motor{};
    Microsteps play{};  // 0 after a motion upwards, the backlash after one downwards
    [[nodiscard]] Microsteps plate() const { return motor + play; }
  };
  // Returns the positions after the motor has moved from `from` to `motor`.
  [[nodiscard]] Rest moved(const Rest& from, Microsteps motor) const {
    return {motor, std::clamp(from.play - (motor - from.motor), Microsteps{0}, backlash_)};
  }

 private:
  double per_mm_;
  Microsteps backlash_;
};

}  // namespace contourd
