// The figures of supports as owners write them: in a resin's profile, and in a ticket in the place of those.
// Pure functions, thread-safe.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/support/support_settings.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {

// A key of `supports`; its value has the unit that the key ends in.
struct SupportFigure {
  std::string_view key;      // "tip_diameter_mm"
  std::string_view setting;  // "supports.tip_diameter_mm": among a resin's other settings
  double (*get)(const SupportSettings&);
  void (*set)(SupportSettings&, double);
};
[[nodiscard]] std::span<const SupportFigure> support_figures();

// What a ticket sets; not yet checked against the others.
struct AskedSupportFigure {
  std::string_view key;  // of support_figures()
  double value = 0;
  bool operator==(const AskedSupportFigure&) const = default;
};

// All keys have to be there, as the schema's defaults see to.
[[nodiscard]] SupportSettings read_support_settings(const JsonSection& supports);
[[nodiscard]] std::vector<AskedSupportFigure> read_asked_figures(const JsonSection& supports);
// What they replace, in the figures' order.
[[nodiscard]] OverriddenSettings override_supports(SupportSettings& settings,
                                                   std::span<const AskedSupportFigure> asked);

// Figures of one profile, or of a ticket with its profile's, that contradict each other.
struct SupportContradiction {
  std::string_view key;  // of the one that is too large or too small
  std::string sentence;  // with both figures
};
[[nodiscard]] std::vector<SupportContradiction> contradictions_of(const SupportSettings& settings);

}  // namespace contourd
