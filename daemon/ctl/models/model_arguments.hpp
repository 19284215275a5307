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
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd::ctl {

// Help texts of these options.
inline constexpr const char* kUpHelp = "Direction that points up: X,Y,Z, or auto, fast, clean, safe";
inline constexpr const char* kUnitHelp = "Unit of the model's file (default: mm)";
inline constexpr const char* kScaleHelp = "Scale the model by this factor";
inline constexpr const char* kAntiAliasingHelp = "Grey edges by area coverage (on), or 1-bit masks (off)";
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

struct DisplayArgs {
  double pixel_pitch_um = 50;
  std::string display = "1920x1080";
};

// The following functions throw UsageError for a value out of its range.
[[nodiscard]] DisplayGeometry parse_display(const DisplayArgs& args);
// Parses a layer height, or a length that is compared with layer heights.
[[nodiscard]] Nanometers parse_um(const char* option, double um, double least);
// Checks that the factor is in the range that a ticket allows.
void check_scale(const std::optional<double>& scale);
// Checks that the output is not the model itself, so that a slip does not destroy the model.
void refuse_to_overwrite_model(const std::filesystem::path& model, const char* option,
                               const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
