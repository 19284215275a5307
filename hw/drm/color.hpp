// What an output does to the values of pixels on their way to the display: gamma tables, a colour matrix, the
// range that black and white are sent in. Masks want none of it: 0 is no light, 255 all of it.
// Pure functions, but for those that take a card.
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
// What must change for pixels to be sent as they are, in full range ("Broadcast RGB": "Full"). Empty when all
// is well, or the driver has no such properties.
[[nodiscard]] std::vector<PropertyChange> changes_to_neutral(const ObjectProperties& crtc,
                                                             const ObjectProperties& connector);

// A legacy gamma table's `size` values of one colour, black to white, that change nothing.
[[nodiscard]] std::vector<std::uint16_t> identity_gamma(std::size_t size);
// Whether that is what the values are to 8 bits, as far as pixels go: hardware may keep no more.
[[nodiscard]] bool is_identity_gamma(std::span<const std::uint16_t> values);

// One of the modes of televisions (CTA-861), which HDMI sends in limited range unless told otherwise: black
// as 16, white as 235 of 255.
[[nodiscard]] bool is_television_mode(const Mode& mode);
// A sentence where the driver cannot be told which range to send, and may choose the limited one. `output`
// names it.
[[nodiscard]] std::optional<std::string> range_warning(const std::string& connector_name, const Mode& mode,
                                                       const ObjectProperties& connector,
                                                       const std::string& output);

// After the mode was set: resets the CRTC's legacy gamma table where that is the only one, reads everything
// back, and returns a sentence for each thing that is not neutral. May block for some refreshes.
[[nodiscard]] std::vector<std::string> settle_color(const Card& card, std::uint32_t crtc_id,
                                                    const Connector& connector, const Mode& mode,
                                                    const std::string& output);

}  // namespace contourd
