// Reads the dimensions of supports in a resin's profile, and in a ticket that overrides them. Pure functions,
// thread-safe.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/support/support_settings.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {

// A key of the section "supports"; its value has the unit that the key ends in.
struct SupportFigure {
  std::string_view key;      // "tip_diameter_mm"
  std::string_view setting;  // the name among all settings of a resin: "supports.tip_diameter_mm"
  double (*get)(const SupportSettings&);
  void (*set)(SupportSettings&, double);
};
[[nodiscard]] std::span<const SupportFigure> support_figures();

// A value that a ticket sets; not yet checked against the other values.
struct AskedSupportFigure {
  std::string_view key;  // a key of support_figures()
  double value = 0;
  bool operator==(const AskedSupportFigure&) const = default;
};

// Reads a profile's section. All keys must be present, which the schema's defaults ensure.
[[nodiscard]] SupportSettings read_support_settings(const JsonSection& supports);
// Reads a ticket's section, in which every key is optional.
[[nodiscard]] std::vector<AskedSupportFigure> read_asked_figures(const JsonSection& supports);
// Sets the values that a ticket asks for. Returns the overridden settings, in the order of support_figures().
[[nodiscard]] OverriddenSettings override_supports(SupportSettings& settings,
                                                   std::span<const AskedSupportFigure> asked);

// A contradiction between two values of a profile, or between a ticket's and its profile's values.
struct SupportContradiction {
  std::string_view key;  // key of the value that is too large or too small
  std::string sentence;  // names both values
};
[[nodiscard]] std::vector<SupportContradiction> contradictions_of(const SupportSettings& settings);

}  // namespace contourd
