#include "daemon/config/hardware_config.hpp"

#include <optional>
#include <string>
#include <utility>

namespace contourd {
namespace {

LineBias read_bias(const JsonSection& section) {
  const std::string word = section.text("bias");
  if (word == "pull_up") return LineBias::PullUp;
  if (word == "pull_down") return LineBias::PullDown;
  return word == "off" ? LineBias::Off : LineBias::AsIs;
}

GpioInputConfig read_input(const JsonSection& input) {
  return {.line = read_gpio_line(input),
          .bias = read_bias(input),
          .debounce = input.duration("debounce_ms"),
          .contact =
              input.text("contact") == "normally_closed" ? Contact::NormallyClosed : Contact::NormallyOpen};
}

// Returns read(section) if the section exists, else nullopt.
template <typename Read>
auto read_if_there(const JsonSection& parent, std::string_view key, Read read) {
  return parent.has(key) ? std::optional(read(parent.section(key))) : std::nullopt;
}

EncoderConfig read_encoder(const JsonSection& encoder) {
  EncoderConfig config;
  config.a = read_gpio_line(encoder.section("a"));
  config.b = read_gpio_line(encoder.section("b"));
  config.bias = read_bias(encoder);
  config.counts_per_mm = encoder.number("counts_per_mm");
  config.reversed = encoder.boolean("reversed");
  config.tolerance = encoder.length("tolerance_um");
  if (encoder.text("policy") == "correct") config.policy = EncoderConfig::Policy::Correct;
  config.most_correction = encoder.length("most_correction_um");
  config.most_correction_sum = encoder.length("most_correction_sum_um");
  config.index = read_if_there(encoder, "index", read_gpio_line);
  if (config.index) config.index_every = encoder.length("index_every_mm");
  return config;
}

std::optional<std::string> read_text(const JsonSection& section, std::string_view key) {
  return section.has(key) ? std::optional(section.text(key)) : std::nullopt;
}

GpioAxisConfig read_gpio_axis(const JsonSection& z_axis) {
  GpioAxisConfig config;
  config.travel = z_axis.length("travel_mm");
  config.microsteps_per_mm = z_axis.number("microsteps_per_mm");
  config.homing_speed = MillimetersPerSecond{z_axis.number("homing_speed_mm_s")};
  config.top_speed = MillimetersPerSecond{z_axis.number("top_speed_mm_s")};
  config.acceleration = MillimetersPerSecondSquared{z_axis.number("acceleration_mm_s2")};
  if (z_axis.has("jerk_mm_s3")) config.jerk_mm_s3 = z_axis.number("jerk_mm_s3");
  config.backlash = z_axis.length("backlash_um");
  config.switch_height = z_axis.length("switch_height_mm");
  config.homes_upwards = z_axis.boolean("homes_upwards");
  config.step = read_gpio_line(z_axis.section("step"));
  config.direction = read_gpio_line(z_axis.section("direction"));
  config.enable = read_if_there(z_axis, "enable", read_gpio_line);
  config.pulse_width = z_axis.duration("pulse_width_us");
  config.direction_setup = z_axis.duration("direction_setup_us");
  config.limit_switch = read_input(z_axis.section("limit_switch"));
  config.second_switch = read_if_there(z_axis, "second_switch", read_input);
  config.encoder = read_if_there(z_axis, "encoder", read_encoder);
  config.emergency_stop = read_if_there(z_axis, "emergency_stop", read_input);
  config.lid = read_if_there(z_axis, "lid", read_input);
  config.realtime_priority = z_axis.integer<int>("realtime_priority");
  return config;
}

DrmDisplayConfig read_drm_display(const JsonSection& display) {
  DrmDisplayConfig config;
  config.card = read_text(display, "card");
  config.connector = read_text(display, "connector");
  config.width = Pixels{display.integer<std::int32_t>("width_px")};
  config.height = Pixels{display.integer<std::int32_t>("height_px")};
  config.refresh_hz = display.number("refresh_hz");
  config.format = display.text("format") == "rgb565" ? DrmDisplayConfig::Format::Rgb565
                                                     : DrmDisplayConfig::Format::Xrgb8888;
  config.buffers = display.integer<int>("buffers");
  config.legacy = display.boolean("legacy_kms");
  config.ignore_edid_size = display.boolean("ignore_edid_size");
  return config;
}

}  // namespace

GpioLineConfig read_gpio_line(const JsonSection& line) {
  return {.chip = line.text("chip"),
          .line = line.text_or_digits("line"),
          .active_low = line.boolean("active_low")};
}

RealMachineConfig read_real_machine(const JsonSection& printer, std::optional<ProjectorConfig> projector) {
  const JsonSection section = printer.section("projector");
  RealMachineConfig config;
  config.axis = read_gpio_axis(printer.section("z_axis"));
  config.display = read_drm_display(printer.section("display"));
  config.warm_up = projector ? warm_up_of(*projector) : section.duration("warm_up_s");
  config.light = read_if_there(section, "light", read_gpio_line);
  config.projector = std::move(projector);
  return config;
}

}  // namespace contourd
