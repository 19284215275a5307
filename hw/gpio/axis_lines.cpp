#include "hw/gpio/axis_lines.hpp"

#include <cmath>
#include <cstdio>

#include "hw/gpio/gpio_lines.hpp"

namespace contourd {
namespace {

std::unique_ptr<InputLine> take_input(const std::optional<GpioInputConfig>& config, const char* use) {
  if (!config) return nullptr;
  return std::make_unique<GpioInput>(config->logical_line(), config->bias, use);
}

}  // namespace

std::optional<std::string> contradiction(const GpioAxisConfig& config) {
  const double rate = config.top_speed.count() * config.microsteps_per_mm;
  char words[160];
  if (rate > kMaxStepsPerSecond) {
    std::snprintf(words, sizeof words,
                  "the axis' top speed of %g mm/s is %.0f steps/s; a computer makes %.0f at most",
                  config.top_speed.count(), rate, kMaxStepsPerSecond);
    return words;
  }
  const double most = most_steps_per_second(config.pulse_width);
  if (rate <= most) return std::nullopt;
  std::snprintf(
      words, sizeof words,
      "the axis' top speed of %g mm/s is %.0f steps/s; pulses of %g us and pauses as long allow %.0f",
      config.top_speed.count(), rate, static_cast<double>(config.pulse_width.count()) / 1e3,
      std::floor(most));
  return words;
}

AxisLines take_lines(const GpioAxisConfig& config) {
  AxisLines lines;
  if (config.enable) lines.enable = std::make_unique<GpioOutput>(*config.enable, "enable", false);
  lines.step = std::make_unique<GpioOutput>(config.step, "step", false);
  lines.direction = std::make_unique<GpioOutput>(config.direction, "direction", false);
  lines.inputs = {take_input(config.limit_switch, "limit switch"),
                  take_input(config.second_switch, "second switch"),
                  take_input(config.emergency_stop, "emergency stop"), take_input(config.lid, "lid")};
  if (const auto& encoder = config.encoder) {
    lines.encoder_a = take_input(GpioInputConfig{encoder->a, encoder->bias, {}}, "encoder A");
    lines.encoder_b = take_input(GpioInputConfig{encoder->b, encoder->bias, {}}, "encoder B");
    if (encoder->index) {
      lines.encoder_index = take_input(GpioInputConfig{*encoder->index, encoder->bias, {}}, "encoder index");
    }
  }
  return lines;
}

}  // namespace contourd
