#include "daemon/config/hardware_config.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <ratio>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/projector_config.hpp"
#include "daemon/json/json_schema.hpp"
#include "hw/gpio/gpio_axis_config.hpp"

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

GpioAxisConfig read_gpio_axis(const JsonSection& z_axis) {
  GpioAxisConfig config;
  config.travel = z_axis.length("travel_mm");
  config.microsteps_per_mm = z_axis.number("microsteps_per_mm");
  config.homing_speed = MillimetersPerSecond{z_axis.number("homing_speed_mm_s")};
  config.top_speed = MillimetersPerSecond{z_axis.number("top_speed_mm_s")};
  config.acceleration = MillimetersPerSecondSquared{z_axis.number("acceleration_mm_s2")};
  config.jerk_mm_s3 = z_axis.find("jerk_mm_s3", &JsonSection::number);
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
  config.power_fail = read_if_there(z_axis, "power_fail", read_input);
  if (z_axis.has("force")) {
    const JsonSection force = z_axis.section("force");
    config.force = {.input = read_input(force), .contact_from = force.length("contact_from_mm")};
  }
  config.realtime_priority = z_axis.integer<int>("realtime_priority");
  return config;
}

DrmDisplayConfig read_drm_display(const JsonSection& display) {
  DrmDisplayConfig config;
  config.card = display.find("card", &JsonSection::text);
  config.connector = display.find("connector", &JsonSection::text);
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

using Pointer = nlohmann::json::json_pointer;

// The largest plausible height of a switch at the bottom, which closes about where the plate touches the
// film. A switch farther away is more likely at the top, and homing downwards to it would drive the plate
// through the film.
constexpr double kFarthestBottomSwitchMm = 10;

bool has(const JsonDocument& printer, const std::string& pointer) {
  return printer.value().contains(Pointer(pointer));
}

// Formats a number as a person writes it: "25" and "25.5".
std::string plain(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

// Returns "z_axis/step" for "/z_axis/step".
std::string key_of(const std::string& pointer) {
  return pointer.substr(1);
}

void require(JsonDocument& printer, const std::string& section, const std::string& key) {
  const std::string pointer = section + "/" + key;
  // A section that is not an object is a violation already.
  if (!printer.value().at(Pointer(section)).is_object() || has(printer, pointer)) return;
  printer.add_violation(pointer, "this key is missing, and \"hardware\" is \"real\": " +
                                     printer_schema().at(Pointer(pointer)).description_here());
}

void check_required_keys(JsonDocument& printer) {
  for (const char* section : {"/z_axis", "/projector"}) {
    if (!has(printer, section)) return;
  }
  for (const char* key : {"top_speed_mm_s", "step", "direction", "limit_switch"})
    require(printer, "/z_axis", key);
  if (has(printer, "/z_axis/force")) require(printer, "/z_axis/force", "line");
  const nlohmann::json& projector = printer.value().at("projector");
  const auto is_there = [&](const char* key) { return projector.contains(key); };
  if (projector.is_object() && std::ranges::none_of(light_keys(), is_there)) {
    printer.add_violation(
        "/projector",
        "nothing turns the light on and off: give a \"light\" line, or a \"port\" and the \"table\" "
        "of a projector that can do it by its serial line");
  }
}

struct UsedLine {
  std::string pointer, chip, line;
};

// Returns "gpiochip0" for "/dev/gpiochip0".
std::string chip_name(const std::string& chip) {
  constexpr std::string_view kFolder = "/dev/";
  return chip.starts_with(kFolder) ? chip.substr(kFolder.size()) : chip;
}

// Returns the line's name or its number without leading zeros, whether the number is given as JSON number or
// text.
std::string line_name(const JsonDocument& printer, const std::string& pointer) {
  if (const auto number = printer.valid_number(pointer)) return plain(*number);
  std::string text = printer.valid_text(pointer).value_or("");
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  while (digits && text.size() > 1 && text.front() == '0')
    text.erase(0, 1);
  return text;
}

// Returns the GPIO lines anywhere in the file: a line is an object with the key "line".
std::vector<UsedLine> used_lines(const JsonDocument& printer) {
  constexpr std::string_view kLine = "/line";
  std::vector<UsedLine> lines;
  const nlohmann::json values = printer.value().flatten();
  for (const auto& [place, value] : values.items()) {
    if (!place.ends_with(kLine)) continue;
    const std::string pointer = place.substr(0, place.size() - kLine.size());
    const auto chip = printer.valid_text(pointer + "/chip");
    const std::string line = line_name(printer, place);
    if (chip && !line.empty()) lines.push_back({pointer, chip_name(*chip), line});
  }
  return lines;
}

// Rejects a line that is used twice under the same name. A chip can also be given by its label and a line by
// its name; that two such names mean the same line is only known once the chip is open.
void check_double_use(JsonDocument& printer) {
  std::map<std::pair<std::string, std::string>, std::string> users;
  for (const UsedLine& used : used_lines(printer)) {
    const auto [first, is_new] = users.try_emplace({used.chip, used.line}, used.pointer);
    if (is_new) continue;
    printer.add_violation(used.pointer, "line " + in_quotes(used.line) + " of " + in_quotes(used.chip) +
                                            " is already used for " + key_of(first->second));
  }
}

void check_speeds(JsonDocument& printer) {
  const auto top = printer.valid_number("/z_axis/top_speed_mm_s");
  if (!top) return;
  for (const char* pointer : {"/z_axis/homing_speed_mm_s", "/z_axis/travel_speed_mm_s"}) {
    const auto speed = printer.valid_number(pointer);
    if (speed && *speed > *top) {
      printer.add_violation(pointer,
                            plain(*speed) + " is more than z_axis/top_speed_mm_s, " + plain(*top) + " mm/s");
    }
  }
  const auto microsteps = printer.valid_number("/z_axis/microsteps_per_mm");
  const auto pulse_us = printer.valid_number("/z_axis/pulse_width_us");
  if (!microsteps || !pulse_us) return;
  const double rate = *top * *microsteps;
  const std::chrono::duration<double, std::micro> pulse_width(*pulse_us);
  const double most = std::min(kMaxStepsPerSecond, most_steps_per_second(pulse_width));
  if (rate <= most) return;
  printer.add_violation("/z_axis/top_speed_mm_s",
                        plain(*top) + " mm/s at " + plain(*microsteps) + " microsteps per mm are " +
                            plain(rate) + " steps a second; the limit is " + plain(most) +
                            (most < kMaxStepsPerSecond ? " with this z_axis/pulse_width_us" : "") +
                            ", that is " + plain(most / *microsteps) + " mm/s");
}

void check_homing(JsonDocument& printer) {
  const auto travel = printer.valid_number("/z_axis/travel_mm");
  const auto height = printer.valid_number("/z_axis/switch_height_mm");
  if (!travel || !height) return;
  const bool upwards =
      has(printer, "/z_axis/homes_upwards") && printer.value().at(Pointer("/z_axis/homes_upwards")) == true;
  if (upwards && *height < *travel) {
    printer.add_violation("/z_axis/switch_height_mm",
                          plain(*height) + " is less than z_axis/travel_mm, " + plain(*travel) +
                              " mm, but the switch is at the top: the plate would run into it");
  }
  if (!upwards && std::fabs(*height) > kFarthestBottomSwitchMm) {
    printer.add_violation("/z_axis/switch_height_mm",
                          plain(*height) + " is more than " + plain(kFarthestBottomSwitchMm) +
                              " mm away from where the plate touches the film, but the switch is at the "
                              "bottom; one at the top needs z_axis/homes_upwards");
  }
}

// Checks that force is watched somewhere on the way down.
void check_force(JsonDocument& printer) {
  const auto from_mm = printer.valid_number("/z_axis/force/contact_from_mm"),
             travel_mm = printer.valid_number("/z_axis/travel_mm");
  if (!from_mm || !travel_mm || *from_mm < *travel_mm) return;
  printer.add_violation("/z_axis/force/contact_from_mm",
                        plain(*from_mm) + " is not less than z_axis/travel_mm, " + plain(*travel_mm) +
                            " mm: no force would ever be resistance");
}

void check_corrections(JsonDocument& printer, double tolerance_um) {
  if (printer.valid_text("/z_axis/encoder/policy") != "correct") return;
  const EncoderConfig defaults;
  const auto limit_um = [&](const char* key, Nanometers otherwise) {
    return printer.valid_number(std::string("/z_axis/encoder/") + key)
        .value_or(to_millimeters(otherwise).count() * 1000);
  };
  const double move_um = limit_um("most_correction_um", defaults.most_correction);
  const double sum_um = limit_um("most_correction_sum_um", defaults.most_correction_sum);
  if (move_um <= tolerance_um) {
    printer.add_violation("/z_axis/encoder/most_correction_um",
                          plain(move_um) + " is not more than tolerance_um, " + plain(tolerance_um) +
                              " um: no move would ever be corrected");
  }
  if (sum_um < move_um) {
    printer.add_violation(
        "/z_axis/encoder/most_correction_sum_um",
        plain(sum_um) + " is less than most_correction_um for a single move, " + plain(move_um) + " um");
  }
}

void check_index(JsonDocument& printer, double tolerance_um) {
  constexpr auto kIndex = "/z_axis/encoder/index", kEvery = "/z_axis/encoder/index_every_mm";
  if (has(printer, kIndex) != has(printer, kEvery)) {
    const bool line = has(printer, kIndex);
    printer.add_violation(line ? kIndex : kEvery,
                          "this needs " + key_of(line ? kEvery : kIndex) + ", which is missing");
  }
  const auto every_mm = printer.valid_number(kEvery);
  if (!every_mm || *every_mm * 1000 > 2 * tolerance_um) return;
  printer.add_violation(kEvery, plain(*every_mm) + " mm are not more than twice tolerance_um, " +
                                    plain(tolerance_um) + " um: a wrong count would never be detected");
}

void check_encoder(JsonDocument& printer) {
  const auto counts_per_mm = printer.valid_number("/z_axis/encoder/counts_per_mm");
  if (!counts_per_mm) return;
  const double tolerance_um = printer.valid_number("/z_axis/encoder/tolerance_um")
                                  .value_or(to_millimeters(EncoderConfig{}.tolerance).count() * 1000);
  check_corrections(printer, tolerance_um);
  check_index(printer, tolerance_um);
  const double count_um = 1000 / *counts_per_mm;
  if (tolerance_um >= count_um) return;
  printer.add_violation("/z_axis/encoder/tolerance_um",
                        plain(tolerance_um) + " is less than one count of the encoder, " + plain(count_um) +
                            " um: every move would look as if steps were lost");
}

void check_projector(JsonDocument& printer) {
  for (const auto& [one, other] : std::array{std::pair{"/projector/port", "/projector/table"},
                                             std::pair{"/projector/table", "/projector/port"},
                                             std::pair{"/projector/brightness", "/projector/table"}}) {
    if (has(printer, one) && !has(printer, other))
      printer.add_violation(one, "this needs " + key_of(other) + ", which is missing");
  }
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

void check_projector_table(JsonDocument& printer, const ProjectorTable& table) {
  const std::string name = in_quotes(printer.valid_text("/projector/table").value_or(""));
  const bool real = printer.valid_text("/hardware") == "real";
  if (real && !table.switches_light() && !has(printer, "/projector/light")) {
    printer.add_violation("/projector/table",
                          "the table " + name + " has no light_on and light_off: give a \"light\" line too");
  }
  const auto brightness = printer.valid_number("/projector/brightness");
  if (!brightness) return;
  if (!table.brightness) {
    printer.add_violation("/projector/brightness", "the table " + name + " has no brightness");
  } else if (*brightness < table.brightness->least || *brightness > table.brightness->most) {
    printer.add_violation("/projector/brightness", plain(*brightness) +
                                                       " is outside the range of the table " + name + ", " +
                                                       std::to_string(table.brightness->least) + " to " +
                                                       std::to_string(table.brightness->most));
  }
}

void check_hardware_rules(JsonDocument& printer) {
  if (printer.valid_text("/hardware") == "real") check_required_keys(printer);
  check_double_use(printer);
  check_speeds(printer);
  check_homing(printer);
  check_force(printer);
  check_encoder(printer);
  check_projector(printer);
}

}  // namespace contourd
