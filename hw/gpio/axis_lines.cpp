#include "hw/gpio/axis_lines.hpp"

#include <cmath>
#include <cstdio>

#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/gpio_lines.hpp"

namespace contourd {
namespace {

std::unique_ptr<InputLine> take_input(const std::optional<GpioInputConfig>& config, const char* use) {
  if (!config) return nullptr;
  return std::make_unique<GpioInput>(config->logical_line(), config->bias, use);
}

constexpr const char *kLimitSwitch = "limit switch", *kSecondSwitch = "second switch",
                     *kEmergencyStop = "emergency stop", *kLid = "lid", *kEncoderA = "encoder A",
                     *kEncoderB = "encoder B", *kEncoderIndex = "encoder index";

}  // namespace

std::optional<std::string> contradiction(const GpioAxisConfig& config) {
  const double rate = config.top_speed.count() * config.microsteps_per_mm;
  char words[160];
  if (rate > kMaxStepsPerSecond) {
    std::snprintf(words, sizeof words,
                  "the axis' top speed of %g mm/s is %.0f steps/s; a computer makes at most %.0f",
                  config.top_speed.count(), rate, kMaxStepsPerSecond);
    return words;
  }
  const double most = most_steps_per_second(config.pulse_width);
  if (rate <= most) return std::nullopt;
  std::snprintf(
      words, sizeof words,
      "the axis' top speed of %g mm/s is %.0f steps/s; pulses and pauses of %g us allow at most %.0f",
      config.top_speed.count(), rate, static_cast<double>(config.pulse_width.count()) / 1e3,
      std::floor(most));
  return words;
}

AxisLines take_lines(const GpioAxisConfig& config) {
  AxisLines lines;
  if (config.enable) lines.enable = std::make_unique<GpioOutput>(*config.enable, "enable", false);
  lines.step = std::make_unique<GpioOutput>(config.step, "step", false);
  lines.direction = std::make_unique<GpioOutput>(config.direction, "direction", false);
  lines.inputs = {take_input(config.limit_switch, kLimitSwitch),
                  take_input(config.second_switch, kSecondSwitch),
                  take_input(config.emergency_stop, kEmergencyStop), take_input(config.lid, kLid)};
  if (const auto& encoder = config.encoder) {
    lines.encoder_a = take_input(GpioInputConfig{encoder->a, encoder->bias, {}}, kEncoderA);
    lines.encoder_b = take_input(GpioInputConfig{encoder->b, encoder->bias, {}}, kEncoderB);
    if (encoder->index) {
      lines.encoder_index = take_input(GpioInputConfig{*encoder->index, encoder->bias, {}}, kEncoderIndex);
    }
  }
  return lines;
}

std::vector<AxisInputState> read_inputs(const GpioAxisConfig& config, const AxisLines& lines,
                                        const AxisInputs& inputs) {
  std::vector<AxisInputState> states;
  const auto add = [&states](const char* name, const GpioLineConfig& where, InputLine& line,
                             std::uint64_t edges) {
    states.push_back({name, describe(where), line.level(), edges});
  };
  const auto add_contact = [&](AxisInput which, const char* name,
                               const std::optional<GpioInputConfig>& contact) {
    if (contact)
      add(name, contact->line, *lines.inputs[static_cast<std::size_t>(which)], inputs.edges(which));
  };
  add_contact(AxisInput::LimitSwitch, kLimitSwitch, config.limit_switch);
  add_contact(AxisInput::SecondSwitch, kSecondSwitch, config.second_switch);
  add_contact(AxisInput::EmergencyStop, kEmergencyStop, config.emergency_stop);
  add_contact(AxisInput::Lid, kLid, config.lid);
  if (!config.encoder) return states;
  add(kEncoderA, config.encoder->a, *lines.encoder_a, inputs.encoder_edges(EncoderLine::A));
  add(kEncoderB, config.encoder->b, *lines.encoder_b, inputs.encoder_edges(EncoderLine::B));
  if (config.encoder->index) {
    add(kEncoderIndex, *config.encoder->index, *lines.encoder_index,
        inputs.encoder_edges(EncoderLine::Index));
  }
  return states;
}

}  // namespace contourd
