#include "daemon/print/print_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <variant>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

struct Setting {
  std::string_view name, unit;
  std::variant<double PrintSettings::*, Nanometers LayerMotion::*, MillimetersPerSecond LayerMotion::*,
               Duration LayerMotion::*, double RiseSettings::*>
      field;
};

constexpr std::array kSettings{Setting{"exposure", "%", &PrintSettings::exposure_percent},
                               Setting{"lift", "mm", &LayerMotion::lift},
                               Setting{"lift-speed", "mm/s", &LayerMotion::lift_speed},
                               Setting{"retract-speed", "mm/s", &LayerMotion::retract_speed},
                               Setting{"rest", "ms", &LayerMotion::rest},
                               Setting{"speed", "mm/h", &RiseSettings::speed_mm_h},
                               Setting{"light", "%", &RiseSettings::light_percent},
                               Setting{"margin", "", &RiseSettings::margin}};
static_assert(std::ranges::equal(kSettings, kPrintSettings, {}, &Setting::name));

const Setting& find(std::string_view name) {
  const auto* const found = std::ranges::find(kSettings, name, &Setting::name);
  expects(found != kSettings.end(), "a print has this setting");
  return *found;
}

void assign(Nanometers& length, double mm) {
  length = Nanometers{std::llround(mm * 1e6)};
}
void assign(MillimetersPerSecond& speed, double value) {
  speed = MillimetersPerSecond{value};
}
void assign(Duration& time, double ms) {
  time = Duration{std::llround(ms * 1e6)};
}

}  // namespace

double value_of(const PrintSettings& settings, std::string_view setting) {
  return std::visit(
      [&](auto member) {
        if constexpr (std::is_same_v<decltype(member), double PrintSettings::*>) {
          return settings.*member;
        } else if constexpr (std::is_same_v<decltype(member), double RiseSettings::*>) {
          return settings.rise.*member;
        } else {
          return figure_of(settings.motion.*member);
        }
      },
      find(setting).field);
}

std::string_view unit_of(std::string_view setting) {
  return find(setting).unit;
}

PrintSettings with_value(PrintSettings settings, std::string_view setting, double value) {
  std::visit(
      [&](auto member) {
        if constexpr (std::is_same_v<decltype(member), double PrintSettings::*>) {
          settings.*member = value;
        } else if constexpr (std::is_same_v<decltype(member), double RiseSettings::*>) {
          settings.rise.*member = value;
        } else {
          assign(settings.motion.*member, value);
        }
      },
      find(setting).field);
  return settings;
}

std::string figure_text(std::string_view setting, double value) {
  const std::string_view unit = unit_of(setting);
  return fmt::format("{:g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::string describe(const SettingChange& change) {
  return fmt::format("from {} on {} {} instead of {}",
                     change.height ? fmt::format("{:.3f} mm", in_mm(*change.height))
                                   : fmt::format("layer {}", change.layer + 1),
                     change.setting, figure_text(change.setting, change.value),
                     figure_text(change.setting, change.before));
}

std::string describe(std::span<const SettingChange> changes) {
  constexpr std::size_t kMost = 20;
  std::string text;
  for (const SettingChange& change : changes.first(std::min(changes.size(), kMost)))
    text += (text.empty() ? "" : "; ") + describe(change);
  if (changes.size() > kMost) text += fmt::format("; and {} more changes", changes.size() - kMost);
  return text;
}

}  // namespace contourd
