// The settings of a print that can be changed while it prints. Value types; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "daemon/config/resin_profile.hpp"

namespace contourd {

struct PrintSettings {
  double exposure_percent = 100;  // share of each layer's planned exposure
  LayerMotion motion;
};

// The settings by name. Their values are in %, mm, mm/s, mm/s and ms.
inline constexpr std::array<std::string_view, 5> kPrintSettings{"exposure", "lift", "lift-speed",
                                                                "retract-speed", "rest"};

// Return a setting's value, its unit, and the settings with another value. `setting` is
// one of kPrintSettings.
[[nodiscard]] double value_of(const PrintSettings& settings, std::string_view setting);
[[nodiscard]] std::string_view unit_of(std::string_view setting);
[[nodiscard]] PrintSettings with_value(PrintSettings settings, std::string_view setting, double value);

// A setting that was changed while the print was under way.
struct SettingChange {
  std::int32_t layer = 0;  // the first layer for which it holds, from 0
  std::string_view setting;
  double value = 0, before = 0;
  bool operator==(const SettingChange&) const = default;
};

// Returns "from layer 12 on exposure 110 % instead of 100 %".
[[nodiscard]] std::string describe(const SettingChange& change);
// Returns the first changes of a print as one text; empty if there are none.
[[nodiscard]] std::string describe(std::span<const SettingChange> changes);

}  // namespace contourd
