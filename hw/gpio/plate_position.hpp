// Where the plate is: by the steps made, over the screw, and by the encoder where there is one. Unknown until
// the axis has homed. Engine and inputs must outlive it. Event loop's thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "hw/gpio/axis_encoder.hpp"
#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/gpio/screw.hpp"
#include "hw/gpio/step_engine.hpp"

namespace contourd {

class PlatePosition {
 public:
  PlatePosition(const GpioAxisConfig& config, StepEngine& engine, const AxisInputs& inputs);

  [[nodiscard]] bool known() const noexcept { return known_; }
  void forget() noexcept { known_ = counted_ = false; }
  // It is unknown until take_switch() and become_known(); the steps are counted on where they were.
  void homing_begins() noexcept {
    counted_ = std::exchange(known_, false);
    homing_shift_.reset();
  }
  // How much higher the switch closed than before that homing, by the steps; nothing where those were not
  // counted.
  [[nodiscard]] std::optional<Nanometers> homing_shift() const noexcept {
    return known_ ? homing_shift_ : std::nullopt;
  }
  // The limit switch closed at `edge`, and the motor has run on a little since: the plate is as many steps
  // from the switch's height. REQUIRES: the motor rests.
  void take_switch(TimePoint edge);
  // It is known from now on, and the encoder agrees. REQUIRES: the motor rests.
  void become_known();

  [[nodiscard]] const Screw& screw() const noexcept { return screw_; }
  // By the steps alone.
  [[nodiscard]] Screw::Rest by_steps() const { return screw_.moved(rest_, Microsteps{engine_.position()}); }
  // REQUIRES: the motor rests.
  void note_rest();
  // Both note the rest that they begin from.
  void move_begins();
  void run_begins();

  // By the encoder where there is one, else by the steps; nothing while it is unknown.
  [[nodiscard]] std::optional<Nanometers> height() const;
  [[nodiscard]] std::optional<Nanometers> height_at(TimePoint time) const;
  // " at 12.345 mm"; empty while it is unknown.
  [[nodiscard]] std::string where() const;

  // What the encoder has to say, as in AxisEncoder: nothing where there is none.
  [[nodiscard]] bool has_encoder() const noexcept { return encoder_.has_value(); }
  [[nodiscard]] AxisEncoder::Finding check_encoder();
  [[nodiscard]] std::optional<std::string> runaway() const;
  [[nodiscard]] AxisEncoder::Finding compare_with_encoder();
  // The plate is where the encoder says. REQUIRES: has_encoder(), the motor rests.
  void take_encoder();

 private:
  [[nodiscard]] EncoderReading reading() const;
  void agree();

  StepEngine& engine_;
  const AxisInputs& inputs_;
  Nanometers switch_height_;
  bool homes_upwards_;
  Screw screw_;
  std::optional<AxisEncoder> encoder_;
  Screw::Rest rest_;  // before the run under way
  bool known_ = false;
  bool counted_ = false;  // all steps since it was known, in homing
  std::optional<Nanometers> homing_shift_;
};

}  // namespace contourd
