#include "daemon/config/support_figures.hpp"

#include <algorithm>
#include <array>

#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

template <Millimeters SupportSettings::*kLength>
constexpr SupportFigure length(std::string_view key, std::string_view setting) {
  return {key, setting, [](const SupportSettings& settings) { return (settings.*kLength).count(); },
          [](SupportSettings& settings, double value) { settings.*kLength = Millimeters{value}; }};
}

constexpr std::array kFigures{
    length<&SupportSettings::tip_diameter>("tip_diameter_mm", "supports.tip_diameter_mm"),
    length<&SupportSettings::tip_depth>("tip_depth_mm", "supports.tip_depth_mm"),
    length<&SupportSettings::tip_length>("tip_length_mm", "supports.tip_length_mm"),
    length<&SupportSettings::pillar_diameter>("pillar_diameter_mm", "supports.pillar_diameter_mm"),
    length<&SupportSettings::foot_diameter>("foot_diameter_mm", "supports.foot_diameter_mm"),
    length<&SupportSettings::foot_height>("foot_height_mm", "supports.foot_height_mm"),
    length<&SupportSettings::clearance>("clearance_mm", "supports.clearance_mm"),
    length<&SupportSettings::lift>("lift_mm", "supports.lift_mm"),
    length<&SupportSettings::bridge>("bridge_mm", "supports.bridge_mm"),
    length<&SupportSettings::spacing>("spacing_mm", "supports.spacing_mm"),
    SupportFigure{"tip_holds_mm2", "supports.tip_holds_mm2",
                  [](const SupportSettings& settings) { return settings.tip_holds_mm2; },
                  [](SupportSettings& settings, double value) { settings.tip_holds_mm2 = value; }},
};

}  // namespace

std::span<const SupportFigure> support_figures() {
  return kFigures;
}

SupportSettings read_support_settings(const JsonSection& supports) {
  SupportSettings settings;
  for (const SupportFigure& figure : kFigures)
    figure.set(settings, supports.number(figure.key));
  return settings;
}

std::vector<AskedSupportFigure> read_asked_figures(const JsonSection& supports) {
  std::vector<AskedSupportFigure> asked;
  for (const SupportFigure& figure : kFigures) {
    if (supports.has(figure.key)) asked.push_back({figure.key, supports.number(figure.key)});
  }
  return asked;
}

OverriddenSettings override_supports(SupportSettings& settings, std::span<const AskedSupportFigure> asked) {
  OverriddenSettings overridden;
  for (const SupportFigure& figure : kFigures) {
    const auto value = std::ranges::find(asked, figure.key, &AskedSupportFigure::key);
    if (value == asked.end()) continue;
    overridden.push_back({figure.setting, value->value, figure.get(settings)});
    figure.set(settings, value->value);
  }
  return overridden;
}

std::vector<SupportContradiction> contradictions_of(const SupportSettings& settings) {
  std::vector<SupportContradiction> found;
  const auto check = [&found](bool wrong, std::string_view key, const std::string& sentence) {
    if (wrong) found.push_back({key, sentence});
  };
  const auto mm = [](Millimeters length) { return decimal(length.count()) + " mm"; };
  check(settings.tip_diameter > settings.pillar_diameter, "tip_diameter_mm",
        mm(settings.tip_diameter) + " is more than pillar_diameter_mm, " + mm(settings.pillar_diameter) +
            ": a tip is no thicker than its pillar");
  check(settings.foot_diameter < settings.pillar_diameter, "foot_diameter_mm",
        mm(settings.foot_diameter) + " is less than pillar_diameter_mm, " + mm(settings.pillar_diameter) +
            ": a foot is no thinner than its pillar");
  check(settings.tip_depth > settings.tip_length, "tip_depth_mm",
        mm(settings.tip_depth) + " is more than tip_length_mm, " + mm(settings.tip_length) +
            ": a tip is not deeper in the model than it is long");
  check(settings.lift < settings.foot_height + settings.tip_length, "lift_mm",
        mm(settings.lift) + " is less than foot_height_mm and tip_length_mm together, " +
            mm(settings.foot_height + settings.tip_length) + ": there is no room for a support");
  return found;
}

}  // namespace contourd
