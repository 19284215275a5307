// Arguments that several commands about models have, as the user typed them, and their checks. Thread-safe
// (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/mask/rasterizer.hpp"
#include "core/model/length_unit.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"
#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Help texts of these options.
inline constexpr const char* kUpHelp = "Direction that points up: X,Y,Z, or auto, fast, clean, safe";
inline constexpr const char* kUnitHelp = "Unit of the model: mm, cm, m, um, inch or foot (default: mm)";
inline constexpr const char* kScaleHelp = "Scale the model by this factor";
inline constexpr const char* kHollowHelp = "Make the model hollow, with walls of this thickness, mm";
inline constexpr const char* kUndersidesHelp = "Light of undersides: plain, or dose to cure them as drawn";
inline constexpr const char* kLikePrinterHelp = "Use this printer configuration, as contourd does";
inline constexpr const char* kPictureHelp = "Write a PNG file instead of drawing; - is standard output";

// The value of --up: a direction of the model, or a preset by which the best direction is found.
using UpOption = std::variant<OrientationPreset, Direction>;

// Parses "auto", "fast", "clean", "safe" or "X,Y,Z"; nullopt stays nullopt. Throws UsageError for any other
// word, and for a direction that is zero or not finite.
[[nodiscard]] std::optional<UpOption> parse_up(const std::optional<std::string>& word);

// Returns the presets for completion in a shell.
[[nodiscard]] std::vector<std::string> up_presets();

// Returns the units of a model's file.
[[nodiscard]] std::vector<std::string> unit_names();

struct SizeArgs {
  std::optional<std::string> unit;
  std::optional<double> scale;
};
// Adds --unit and --scale.
void add_size_options(Command& command, SizeArgs& args);

struct DisplayArgs {
  double pixel_pitch_um = 50;
  std::string display = "1920x1080";
  std::string anti_aliasing = "on";
};
// Adds --display, --pixel-pitch-um and --aa. They exclude --printer, if it is given.
void add_display_options(Command& command, DisplayArgs& args, const Option* printer = nullptr);
// Returns the value of --aa.
[[nodiscard]] AntiAliasing parse_anti_aliasing(const DisplayArgs& args);

// The following functions throw UsageError for a value out of its range.
[[nodiscard]] DisplayGeometry parse_display(const DisplayArgs& args);
// Parses a layer height, or a length that is compared with layer heights.
[[nodiscard]] Nanometers parse_um(const char* option, double um, double least);
// Parses a unit by any of its names: "inch", "inches", "in".
[[nodiscard]] std::optional<LengthUnit> parse_unit(const std::optional<std::string>& word);
// Returns the factor by which the model's coordinates are multiplied; nullopt if no option is given. --scale
// has the range of a ticket's scale.
[[nodiscard]] std::optional<double> parse_size(const SizeArgs& args);
// Parses the thickness of a hollow model's walls; nullopt stays nullopt.
[[nodiscard]] std::optional<Millimeters> parse_hollow(std::optional<double> wall_mm);
// Checks that the output is not the model itself, so that a slip does not destroy the model.
void refuse_to_overwrite_model(const std::filesystem::path& model, const char* option,
                               const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
