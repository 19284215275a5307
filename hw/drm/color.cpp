#include "hw/drm/color.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "hw/owned.hpp"

namespace contourd {
namespace {

using KernelCrtc = Owned<drmModeCrtc, drmModeFreeCrtc>;

constexpr const char* kRange = "Broadcast RGB";
constexpr const char* kGammaTable = "GAMMA_LUT";

void add_change(std::vector<PropertyChange>& changes, const ObjectProperties& object, std::uint32_t type,
                const std::string& name, std::uint64_t value) {
  const auto property = object.find(name);
  if (property && property->value != value)
    changes.push_back({object.object(), type, property->id, value, name});
}

// The gamma tables of all three colours.
struct LegacyGamma {
  std::vector<std::uint16_t> red, green, blue;
  bool readable = true;
};
// Reads the CRTC's gamma tables. Returns nullopt if it has none.
std::optional<LegacyGamma> read_gamma(const Card& card, std::uint32_t crtc_id) {
  const KernelCrtc crtc(drmModeGetCrtc(card.fd(), crtc_id));
  if (!crtc || crtc->gamma_size <= 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(crtc->gamma_size);
  LegacyGamma gamma{std::vector<std::uint16_t>(size), std::vector<std::uint16_t>(size),
                    std::vector<std::uint16_t>(size)};
  gamma.readable = drmModeCrtcGetGamma(card.fd(), crtc_id, static_cast<std::uint32_t>(size), gamma.red.data(),
                                       gamma.green.data(), gamma.blue.data()) == 0;
  return gamma;
}

bool is_identity(const LegacyGamma& gamma) {
  return gamma.readable && is_identity_gamma(gamma.red) && is_identity_gamma(gamma.green) &&
         is_identity_gamma(gamma.blue);
}

// Makes the table the identity; true if it is now. Changes it only if needed, because that blanks some
// outputs.
bool reset_legacy_gamma(const Card& card, std::uint32_t crtc_id) {
  const std::optional<LegacyGamma> before = read_gamma(card, crtc_id);
  if (!before || is_identity(*before)) return true;
  std::vector<std::uint16_t> identity = identity_gamma(before->red.size());
  const int error = drmModeCrtcSetGamma(card.fd(), crtc_id, static_cast<std::uint32_t>(identity.size()),
                                        identity.data(), identity.data(), identity.data());
  const std::optional<LegacyGamma> after = read_gamma(card, crtc_id);
  return error == 0 && after && is_identity(*after);
}

}  // namespace

std::vector<PropertyChange> changes_to_neutral(const ObjectProperties& crtc,
                                               const ObjectProperties& connector) {
  std::vector<PropertyChange> changes;
  for (const char* correction : {kGammaTable, "DEGAMMA_LUT", "CTM"})
    add_change(changes, crtc, DRM_MODE_OBJECT_CRTC, correction, 0);
  for (const char* meaning : {"Colorspace", "HDR_OUTPUT_METADATA"})
    add_change(changes, connector, DRM_MODE_OBJECT_CONNECTOR, meaning, 0);
  if (const auto full = connector.value_called(kRange, "Full"))
    add_change(changes, connector, DRM_MODE_OBJECT_CONNECTOR, kRange, *full);
  return changes;
}

std::vector<std::uint16_t> identity_gamma(std::size_t size) {
  std::vector<std::uint16_t> values(size);
  for (std::size_t i = 0; i < size; ++i)
    values[i] = static_cast<std::uint16_t>(size == 1 ? 0xffff : (i * 0xffff + (size - 1) / 2) / (size - 1));
  return values;
}

bool is_identity_gamma(std::span<const std::uint16_t> values) {
  const std::vector<std::uint16_t> identity = identity_gamma(values.size());
  constexpr int kOneOf255 = 0x101;
  return std::ranges::equal(values, identity, [](int a, int b) { return std::abs(a - b) <= kOneOf255; });
}

bool is_television_mode(const Mode& mode) {
  struct Timing {
    int width, height, total;
  };
  // The progressive modes. Modes of one size differ between refresh rates in the pixels of a whole line.
  static constexpr std::array kTimings{
      Timing{720, 480, 858},    Timing{720, 576, 864},    Timing{1280, 720, 1650},  Timing{1280, 720, 1980},
      Timing{1280, 720, 3300},  Timing{1280, 720, 3960},  Timing{1920, 1080, 2200}, Timing{1920, 1080, 2640},
      Timing{1920, 1080, 2750}, Timing{3840, 2160, 4400}, Timing{3840, 2160, 5280}, Timing{3840, 2160, 5500},
      Timing{4096, 2160, 4400}, Timing{4096, 2160, 5280}, Timing{4096, 2160, 5500}};
  return std::ranges::any_of(kTimings, [&](const Timing& timing) {
    return timing.width == mode.hdisplay && timing.height == mode.vdisplay && timing.total == mode.htotal;
  });
}

std::optional<std::string> range_warning(const std::string& connector_name, const Mode& mode,
                                         const ObjectProperties& connector, const std::string& output) {
  const bool has_ranges = connector_name.starts_with("HDMI") || connector_name.starts_with("DP");
  if (!has_ranges || !is_television_mode(mode) || connector.value_called(kRange, "Full")) return std::nullopt;
  return output + " has no \"" + kRange +
         "\" property: if its driver chooses the limited range for this mode, black is shown at 16 of 255, "
         "6 % of the light (docs/printer-setup.md, \"Limited range\")";
}

std::vector<std::string> settle_color(const Card& card, std::uint32_t crtc_id, const Connector& connector,
                                      const Mode& mode, const std::string& output) {
  ObjectProperties crtc(card.fd(), crtc_id, DRM_MODE_OBJECT_CRTC);
  const ObjectProperties on(card.fd(), connector.id, DRM_MODE_OBJECT_CONNECTOR);
  std::vector<std::string> warnings;
  if (!crtc.find(kGammaTable) && !reset_legacy_gamma(card, crtc_id))
    warnings.push_back(output +
                       " keeps a gamma table that its driver cannot reset: grey gets more or less light "
                       "than the mask says, and black may not be dark");
  for (const PropertyChange& change : changes_to_neutral(crtc, on)) {
    warnings.push_back(output + " ignored the change of its \"" + change.name + "\" property: " +
                       (change.name == kRange ? "black may be shown at 16 of 255, 6 % of the light"
                                              : "grey may get more or less light than the mask says"));
  }
  if (auto warning = range_warning(connector.name, mode, on, output)) warnings.push_back(std::move(*warning));
  return warnings;
}

}  // namespace contourd
