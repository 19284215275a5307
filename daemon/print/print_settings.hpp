// The settings of a print that can be changed while it prints. Value types; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/geometry/units.hpp"
#include "daemon/config/resin_profile.hpp"

namespace contourd {

// The settings of a print's rises; 0 in a print without rises.
struct RiseSettings {
  double speed_mm_h = 0;       // the plate rises no faster
  double light_percent = 100;  // share of the lamp's light in white pixels
  double margin = 0;           // least dose over the critical one
  bool operator==(const RiseSettings&) const = default;
};

struct PrintSettings {
  double exposure_percent = 100;  // share of each layer's planned exposure
  LayerMotion motion;
  RiseSettings rise{};
};

// The settings by name. Their values are in %, mm, mm/s, mm/s and ms; those of rises in mm/h, % and without a
// unit.
inline constexpr std::array<std::string_view, 8> kPrintSettings{
    "exposure", "lift", "lift-speed", "retract-speed", "rest", "speed", "light", "margin"};
// True for the settings of rises, which hold from now on and not from the next layer on.
[[nodiscard]] constexpr bool is_of_rises(std::string_view setting) {
  return setting == "speed" || setting == "light" || setting == "margin";
}

// Return a setting's value, its unit, and the settings with another value. `setting` is
// one of kPrintSettings.
[[nodiscard]] double value_of(const PrintSettings& settings, std::string_view setting);
[[nodiscard]] std::string_view unit_of(std::string_view setting);
[[nodiscard]] PrintSettings with_value(PrintSettings settings, std::string_view setting, double value);

// Returns a setting's value with its unit: "110 %".
[[nodiscard]] std::string figure_text(std::string_view setting, double value);

// A setting that was changed while the print was under way.
struct SettingChange {
  std::int32_t layer = 0;  // the first layer for which it holds, from 0
  std::string_view setting;
  double value = 0, before = 0;
  std::optional<Nanometers> height{};  // from which on it holds, within a rise
  bool operator==(const SettingChange&) const = default;
};

// Returns "from layer 12 on exposure 110 % instead of 100 %", or "from 3.120 mm on ...".
[[nodiscard]] std::string describe(const SettingChange& change);
// Returns the first changes of a print as one text; empty if there are none.
[[nodiscard]] std::string describe(std::span<const SettingChange> changes);

}  // namespace contourd
