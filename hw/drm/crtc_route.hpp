// By which CRTC and plane a connector can be fed. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"
#include "hw/drm/pixel_format.hpp"

namespace contourd {

// A CRTC that may feed a connector, and the plane of pictures that fills it.
struct CrtcRoute {
  std::uint32_t crtc_id = 0, plane_id = 0;
  std::vector<std::uint32_t> formats;  // of the plane, DRM_FORMAT_*
};

// Best first: that which feeds the connector now, then idle ones, then those that feed another one. Throws
// HardwareError when there is none.
[[nodiscard]] std::vector<CrtcRoute> routes_to(const Card& card, const Connector& connector);

// "XR24 RG16"
[[nodiscard]] std::string describe_formats(const std::vector<std::uint32_t>& formats);

// Throws HardwareError with the formats there are when the route's plane does not show this one. `output` is
// named in it.
void check_format(const CrtcRoute& route, PixelFormat format, const std::string& output);

}  // namespace contourd
