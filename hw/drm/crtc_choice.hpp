// Which kind of CRTC a card gets.
#pragma once

#include <cstdint>
#include <memory>

#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/mode.hpp"

namespace contourd {

// Atomic where the driver has it and a test commit of the mode with this picture succeeds, else legacy;
// changes nothing on the screen. The card must outlive it. Throws HardwareError. A card that is not DRM
// master cannot test, and gets the legacy kind.
[[nodiscard]] std::unique_ptr<Crtc> make_crtc(const Card& card, const Connector& connector, const Mode& mode,
                                              std::uint32_t picture, bool legacy);

}  // namespace contourd
