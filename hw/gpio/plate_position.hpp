// The plate's position, from the steps made and the screw, and from the encoder if there is one. Unknown
// until the axis has homed. Engine and inputs must outlive this object. Event loop's thread only.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "core/geometry/units.hpp"
#include "hw/gpio/axis_encoder.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {

// The screw between motor and plate. It moves in whole microsteps and has backlash: when the motor turns
// downwards the plate follows later. Positions are in microsteps.
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

class PlatePosition {
 public:
  PlatePosition(const GpioAxisConfig& config, StepEngine& engine, const AxisInputs& inputs);

  [[nodiscard]] bool known() const noexcept { return known_; }
  void forget() noexcept { known_ = counted_ = false; }
  // Makes the position unknown until take_switch() and become_known(). Remembers whether it was known, so
  // that the steps since then give homing_shift().
  void homing_begins() noexcept {
    counted_ = std::exchange(known_, false);
    homing_shift_.reset();
    contact_ = {};
  }
  // Returns how much higher than before the switch closed in the last homing, by the steps; nullopt if the
  // position was unknown before that homing.
  [[nodiscard]] std::optional<Nanometers> homing_shift() const noexcept {
    return known_ ? homing_shift_ : std::nullopt;
  }
  // Sets the height at which the plate, or the part on it, meets the film; 0 at first and from homing on.
  void expect_contact_at(Nanometers height) noexcept { contact_ = height; }
  // Returns the motor's position when the plate, on its way down, is this far above that height.
  [[nodiscard]] Microsteps above_contact(Nanometers distance) const {
    return screw_.nearest_step(contact_ + distance) - screw_.backlash();
  }
  // Sets the position from the limit switch, which closed at `edge`: the plate is as far from the switch's
  // height as the motor has moved since. REQUIRES: the motor rests.
  void take_switch(TimePoint edge);
  // Makes the position known as this height, at which the plate rests after a motion upwards. REQUIRES: the
  // motor rests.
  void assume(Nanometers height);
  // Makes the position known and sets the encoder's position to it. REQUIRES: the motor rests.
  void become_known();

  [[nodiscard]] const Screw& screw() const noexcept { return screw_; }
  // Returns the position by the steps alone.
  [[nodiscard]] Screw::Rest by_steps() const { return screw_.moved(rest_, Microsteps{engine_.position()}); }
  // Records the position at which the motor rests. REQUIRES: the motor rests.
  void note_rest();
  // Both record the position at which they begin, as note_rest().
  void move_begins();
  void run_begins();

  // Both return the height by the encoder if there is one, else by the steps; nullopt while it is unknown.
  [[nodiscard]] std::optional<Nanometers> height() const;
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const;
  // Returns " at 12.345 mm", or an empty string while the height is unknown.
  [[nodiscard]] std::string where() const;

  // The encoder's checks, see AxisEncoder; without an encoder they find nothing.
  [[nodiscard]] bool has_encoder() const noexcept { return encoder_.has_value(); }
  [[nodiscard]] AxisEncoder::Finding check_encoder() {
    return encoder_ ? encoder_->check(reading(), known_) : AxisEncoder::Finding{};
  }
  [[nodiscard]] std::optional<std::string> runaway() const {
    return encoder_ ? encoder_->runaway(reading(), by_steps().plate().count(), known_) : std::nullopt;
  }
  [[nodiscard]] AxisEncoder::Finding compare_with_encoder() {
    return encoder_ ? encoder_->compare(reading(), by_steps().plate().count()) : AxisEncoder::Finding{};
  }
  // Sets the position by the steps to that of the encoder. REQUIRES: has_encoder(), the motor rests.
  void take_encoder();

 private:
  [[nodiscard]] EncoderReading reading() const;
  void agree() {
    if (encoder_) encoder_->agree(reading(), by_steps().plate().count());
  }

  StepEngine& engine_;
  const AxisInputs& inputs_;
  Nanometers switch_height_;
  bool homes_upwards_;
  Screw screw_;
  std::optional<AxisEncoder> encoder_;
  Screw::Rest rest_;  // the last position at rest
  bool known_ = false;
  bool counted_ = false;  // during homing: the position was known before, and all steps since are counted
  std::optional<Nanometers> homing_shift_;
  Nanometers contact_{};
};

}  // namespace contourd
