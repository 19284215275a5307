#include "core/orientation/orientation_figures.hpp"

#include <array>

namespace contourd {
namespace {

struct Preset {
  OrientationPreset preset;
  std::string_view name;
};
constexpr std::array kPresets{
    Preset{OrientationPreset::Auto, "auto"}, Preset{OrientationPreset::Fast, "fast"},
    Preset{OrientationPreset::Clean, "clean"}, Preset{OrientationPreset::Safe, "safe"}};

}  // namespace

std::string_view name_of(OrientationPreset preset) {
  for (const Preset& each : kPresets)
    if (each.preset == preset) return each.name;
  return "";
}

std::optional<OrientationPreset> orientation_preset(std::string_view word) {
  for (const Preset& each : kPresets)
    if (each.name == word) return each.preset;
  return std::nullopt;
}

OrientationWeights weights_of(OrientationPreset preset, const OrientationWeights& own) {
  const double clean = own.keep_clean;
  switch (preset) {
    case OrientationPreset::Fast:
      return {
          .support = 0.5, .contacts = 0.5, .peel = 0.25, .height = 4, .standing = 0.25, .keep_clean = clean};
    case OrientationPreset::Clean:
      return {
          .support = 0.5, .contacts = 4, .peel = 0.25, .height = 0.25, .standing = 0.5, .keep_clean = clean};
    case OrientationPreset::Safe:
      return {.support = 0.5, .contacts = 1, .peel = 3, .height = 0.25, .standing = 1.5, .keep_clean = clean};
    case OrientationPreset::Auto:
      break;
  }
  return own;
}

}  // namespace contourd
