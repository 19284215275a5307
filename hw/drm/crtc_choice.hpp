// The choice between the atomic and the legacy CRTC.
#pragma once

#include <cstdint>
#include <memory>

#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/mode.hpp"

namespace contourd {

// Returns an atomic CRTC if `legacy` is false, the driver supports atomic calls and a test commit of the mode
// with this picture succeeds; otherwise a legacy one. Changes nothing on the screen. A card that is not DRM
// master cannot run the test and gets a legacy CRTC. The card must outlive the CRTC. Throws HardwareError.
[[nodiscard]] std::unique_ptr<Crtc> make_crtc(const Card& card, const Connector& connector, const Mode& mode,
                                              std::uint32_t picture, bool legacy);

}  // namespace contourd
