#include "daemon/ctl/models/model_arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>
#include <system_error>

#include "core/layers/layers.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {

std::optional<UpOption> parse_up(const std::optional<std::string>& given) {
  if (!given) return std::nullopt;
  const std::string& word = *given;
  if (const auto preset = orientation_preset(word)) return *preset;
  Direction up;
  int used = 0;
  const int parts = std::sscanf(word.c_str(), "%lf,%lf,%lf%n", &up.x, &up.y, &up.z, &used);
  if (parts != 3 || static_cast<std::size_t>(used) != word.size())
    throw UsageError(fmt::format("--up {}: expected auto, fast, clean, safe or X,Y,Z", printable(word)));
  const bool finite = std::isfinite(up.x) && std::isfinite(up.y) && std::isfinite(up.z);
  if (!finite || up == Direction{0, 0, 0})
    throw UsageError(
        fmt::format("--up {}: expected a direction that is finite and not zero", printable(word)));
  return up;
}

std::vector<std::string> up_presets() {
  return {"auto", "fast", "clean", "safe"};
}

std::vector<std::string> unit_names() {
  return {"mm", "cm", "m", "um", "inch", "foot"};
}

void add_display_options(Command& command, DisplayArgs& args, const Option* printer) {
  Option& display = command.option("--display", args.display, "Display size in pixels, WIDTHxHEIGHT");
  Option& pitch = command.option("--pixel-pitch-um", args.pixel_pitch_um, "Side of a pixel on the plate, um");
  Option& anti_aliasing =
      command.option("--aa", args.anti_aliasing, "Grey edges by area coverage (on), or 1-bit masks (off)")
          .one_of({"on", "off"});
  if (printer == nullptr) return;
  for (Option* option : {&display, &pitch, &anti_aliasing})
    option->excludes(*printer);
}

AntiAliasing parse_anti_aliasing(const DisplayArgs& args) {
  return args.anti_aliasing == "on" ? AntiAliasing::On : AntiAliasing::Off;
}

DisplayGeometry parse_display(const DisplayArgs& args) {
  DisplayGeometry display;
  int width = 0, height = 0, used = 0;
  const int parts = std::sscanf(args.display.c_str(), "%dx%d%n", &width, &height, &used);
  constexpr int kLargest = 16384;
  if (parts != 2 || static_cast<std::size_t>(used) != args.display.size() || width < 1 || height < 1 ||
      width > kLargest || height > kLargest) {
    throw UsageError(
        fmt::format("--display {}: expected WIDTHxHEIGHT, each 1 to {} pixels", args.display, kLargest));
  }
  if (!(args.pixel_pitch_um >= 0.1 && args.pixel_pitch_um <= 10000)) {
    throw UsageError(fmt::format("--pixel-pitch-um {}: expected 0.1 to 10000", args.pixel_pitch_um));
  }
  display.width = Pixels{width};
  display.height = Pixels{height};
  display.pixel_pitch = Micrometers{args.pixel_pitch_um};
  return display;
}

Nanometers parse_um(const char* option, double um, double least) {
  const auto length = to_nanometers(to_millimeters(Micrometers{um}));
  if (!length || !(um >= least) || *length > kThickestLayer) {
    throw UsageError(fmt::format("{} {}: expected {} to {:.0f}", option, um, least,
                                 to_millimeters(kThickestLayer).count() * 1000));
  }
  return *length;
}

std::optional<LengthUnit> parse_unit(const std::optional<std::string>& word) {
  if (!word) return std::nullopt;
  if (const std::optional<LengthUnit> unit = length_unit(*word)) return unit;
  throw UsageError(fmt::format("--unit {}: expected {}", printable(*word), fmt::join(unit_names(), ", ")));
}

std::optional<double> parse_size(const SizeArgs& args) {
  const std::optional<double>& scale = args.scale;
  // Negated, so that NaN is refused, too.
  if (scale && !(*scale >= 0.001 && *scale <= 1000))
    throw UsageError(fmt::format("--scale {}: expected 0.001 to 1000", *scale));
  const std::optional<LengthUnit> unit = parse_unit(args.unit);
  return unit ? millimeters_in(*unit) * scale.value_or(1) : scale;
}

std::optional<Millimeters> parse_hollow(std::optional<double> wall_mm) {
  if (!wall_mm) return std::nullopt;
  // Negated, so that NaN is refused, too.
  if (!(*wall_mm >= 0.2 && *wall_mm <= 30))
    throw UsageError(fmt::format("--hollow {}: expected 0.2 to 30", *wall_mm));
  return Millimeters{*wall_mm};
}

void add_size_options(Command& command, SizeArgs& args) {
  command.option("--unit", args.unit, kUnitHelp).suggests(unit_names);
  command.option("--scale", args.scale, kScaleHelp);
}

void refuse_to_overwrite_model(const std::filesystem::path& model, const char* option,
                               const std::optional<std::filesystem::path>& output) {
  std::error_code ignored;  // a file that does not exist is not the model
  if (output && std::filesystem::equivalent(*output, model, ignored))
    throw UsageError(fmt::format("{} {}: this file is the model", option, output->string()));
}

}  // namespace contourd::ctl
