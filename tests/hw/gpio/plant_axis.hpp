// Configurations of an axis for the plant, and the position of its plate.
#pragma once

#include "hw/gpio/gpio_axis_config.hpp"
#include "tests/hw/gpio/plant.hpp"

namespace contourd::testing {

// Returns a 4 mm screw at 16 microsteps: 1.25 um per step, 4,000 steps/s at homing speed.
inline GpioAxisConfig screw_config() {
  GpioAxisConfig config;
  config.travel = Nanometers{100'000'000};
  config.step.line = "17";
  config.limit_switch.line.line = "23";
  config.acceleration = MillimetersPerSecondSquared{50};
  return config;
}
inline GpioAxisConfig with_second_switch(GpioAxisConfig config = screw_config()) {
  config.second_switch = GpioInputConfig{{"gpiochip0", "24", false}};
  return config;
}
// Adds an encoder of one count per step.
inline GpioAxisConfig with_encoder(EncoderConfig::Policy policy, GpioAxisConfig config = screw_config()) {
  config.encoder = EncoderConfig{};
  config.encoder->counts_per_mm = 800;
  config.encoder->policy = policy;
  return config;
}

// A plant whose axis has been built.
struct BuiltPlant : Plant {
  explicit BuiltPlant(const GpioAxisConfig& of = screw_config()) : Plant(of) { build(); }
};
// A plant whose axis has homed.
struct HomedPlant : Plant {
  explicit HomedPlant(const GpioAxisConfig& of = screw_config()) : Plant(of) { build_homed(); }
};

// Returns how many steps the plate is above the switch.
inline std::int64_t plate_above_switch(const Plant& plant) {
  return plant.plate() - plant.limit.at;
}

}  // namespace contourd::testing
