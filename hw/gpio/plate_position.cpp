#include "hw/gpio/plate_position.hpp"

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_fault.hpp"

namespace contourd {

PlatePosition::PlatePosition(const GpioAxisConfig& config, StepEngine& engine, const AxisInputs& inputs)
    : engine_(engine),
      inputs_(inputs),
      switch_height_(config.switch_height),
      homes_upwards_(config.homes_upwards),
      screw_(config.microsteps_per_mm, config.backlash),
      encoder_(config.encoder ? std::optional<AxisEncoder>(std::in_place, config, *config.encoder)
                              : std::nullopt) {}

void PlatePosition::take_switch(TimePoint edge) {
  expects(!engine_.moving(), "the motor rests");
  const Microsteps beyond{engine_.position() - engine_.position_at(edge)};
  const Microsteps play = homes_upwards_ ? Microsteps{0} : screw_.backlash();
  const Microsteps now = screw_.nearest_step(switch_height_) - play + beyond;
  if (std::exchange(counted_, false))
    homing_shift_ = screw_.height(static_cast<double>(engine_.position() - now.count()));
  engine_.set_position(now.count());
  rest_ = {Microsteps{engine_.position()}, play};
}

void PlatePosition::become_known() {
  expects(!engine_.moving(), "the motor rests");
  agree();
  known_ = true;
}

void PlatePosition::assume(Nanometers height) {
  expects(!engine_.moving(), "the motor rests");
  engine_.set_position(screw_.nearest_step(height).count());
  rest_ = {Microsteps{engine_.position()}, Microsteps{0}};
  become_known();
}

void PlatePosition::note_rest() {
  expects(!engine_.moving(), "the motor rests");
  rest_ = by_steps();
}

void PlatePosition::move_begins() {
  note_rest();
  if (encoder_) encoder_->move_begins(reading());
}

void PlatePosition::run_begins() {
  note_rest();
  if (!known_) agree();
}

std::optional<Nanometers> PlatePosition::height() const {
  if (!known_) return std::nullopt;
  return screw_.height(encoder_ ? encoder_->plate(reading())
                                : static_cast<double>(by_steps().plate().count()));
}

std::optional<Nanometers> PlatePosition::height_at(TimePoint time) const {
  if (!known_) return std::nullopt;
  const double made =
      static_cast<double>(screw_.moved(rest_, Microsteps{engine_.position_at(time)}).plate().count());
  const double off =
      encoder_ ? encoder_->plate(reading()) - static_cast<double>(by_steps().plate().count()) : 0;
  return screw_.height(made + off);
}

std::string PlatePosition::where() const {
  if (!known_) return "";
  return " at " + millimeters(to_millimeters(*height()).count());
}

EncoderReading PlatePosition::reading() const {
  const AxisInputs::IndexPulse pulse = inputs_.index_pulse();
  return {inputs_.encoder_count(), inputs_.illegal_encoder_edges(), pulse.number, pulse.count};
}

void PlatePosition::take_encoder() {
  expects(encoder_.has_value(), "the axis has an encoder");
  expects(!engine_.moving(), "the motor rests");
  engine_.set_position(std::llround(encoder_->plate(reading())) - rest_.play.count());
  rest_.motor = Microsteps{engine_.position()};
}

}  // namespace contourd
