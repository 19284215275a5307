#include "hw/drm/crtc_choice.hpp"

#include <xf86drm.h>

#include <vector>

#include "hw/drm/atomic_crtc.hpp"
#include "hw/drm/crtc_route.hpp"
#include "hw/drm/legacy_crtc.hpp"

namespace contourd {

std::unique_ptr<Crtc> make_crtc(const Card& card, const Connector& connector, const Mode& mode,
                                std::uint32_t picture, bool legacy) {
  const std::vector<CrtcRoute> routes = routes_to(card, connector);
  const bool atomic = !legacy && drmSetClientCap(card.fd(), DRM_CLIENT_CAP_ATOMIC, 1) == 0;
  for (std::size_t i = 0; atomic && i < routes.size(); ++i) {
    auto crtc = std::make_unique<AtomicCrtc>(card, connector, routes[i], mode);
    if (crtc->test_mode(picture) == 0) return crtc;
  }
  return std::make_unique<LegacyCrtc>(card, connector, routes.front(), mode);
}

}  // namespace contourd
