// The CRTCs and planes that can feed a connector. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"
#include "hw/drm/drm_display_config.hpp"

namespace contourd {

// A CRTC that can feed a connector, and its primary plane.
struct CrtcRoute {
  std::uint32_t crtc_id = 0, plane_id = 0;
  std::vector<std::uint32_t> formats;  // the plane's formats, DRM_FORMAT_*
};

// Returns the routes to a connector, best first: the CRTC that feeds it now, then idle CRTCs, then CRTCs that
// feed other connectors. Throws HardwareError if there is none.
[[nodiscard]] std::vector<CrtcRoute> routes_to(const Card& card, const Connector& connector);

// "XR24 RG16"
[[nodiscard]] std::string describe_formats(const std::vector<std::uint32_t>& formats);

// Throws HardwareError that names `output` and lists the plane's formats if the plane does not support this
// format.
void check_format(const CrtcRoute& route, PixelFormat format, const std::string& output);

}  // namespace contourd
