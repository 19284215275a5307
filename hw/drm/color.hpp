// Changes that an output makes to pixel values on their way to the display: gamma tables, a colour matrix,
// the range in which black and white are sent. Masks need none of them: 0 is no light, 255 is full light.
// Pure functions, except those that take a card.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hw/drm/atomic_request.hpp"
#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"

namespace contourd {

// A property of a CRTC or connector that should have another value.
struct PropertyChange {
  std::uint32_t object = 0, type = 0;  // DRM_MODE_OBJECT_*
  std::uint32_t property = 0;
  std::uint64_t value = 0;
  std::string name;
};
// Returns the property changes after which pixels are sent unchanged, in full range ("Broadcast RGB":
// "Full"). Empty if no change is needed or the driver has no such properties.
[[nodiscard]] std::vector<PropertyChange> changes_to_neutral(const ObjectProperties& crtc,
                                                             const ObjectProperties& connector);

// Returns one colour of a legacy gamma table that changes nothing: `size` values from black to white.
[[nodiscard]] std::vector<std::uint16_t> identity_gamma(std::size_t size);
// True if the values are those of identity_gamma() to 8 bits, a pixel's precision. Hardware may store no
// more.
[[nodiscard]] bool is_identity_gamma(std::span<const std::uint16_t> values);

// True if the mode is a television mode (CTA-861), which HDMI by default sends in limited range: black as 16,
// white as 235 of 255.
[[nodiscard]] bool is_television_mode(const Mode& mode);
// Returns a sentence if the driver has no property for the range and may choose the limited one. `output` is
// the output's name in that sentence.
[[nodiscard]] std::optional<std::string> range_warning(const std::string& connector_name, const Mode& mode,
                                                       const ObjectProperties& connector,
                                                       const std::string& output);

// To be called after the mode was set. Resets the CRTC's legacy gamma table if it has no other, reads all
// colour settings back, and returns a sentence for each that is not neutral. May block for some refreshes.
[[nodiscard]] std::vector<std::string> settle_color(const Card& card, std::uint32_t crtc_id,
                                                    const Connector& connector, const Mode& mode,
                                                    const std::string& output);

}  // namespace contourd
