#include "hw/drm/crtc_route.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <utility>

#include "hw/drm/atomic_request.hpp"
#include "hw/drm/dumb_buffer.hpp"
#include "hw/hardware_error.hpp"
#include "hw/owned.hpp"

namespace contourd {
namespace {

using PlaneResources = Owned<drmModePlaneRes, drmModeFreePlaneResources>;
using KernelPlane = Owned<drmModePlane, drmModeFreePlane>;

bool is_primary(int fd, std::uint32_t plane) {
  const auto type = ObjectProperties(fd, plane, DRM_MODE_OBJECT_PLANE).find("type");
  return type && type->value == DRM_PLANE_TYPE_PRIMARY;
}

// Returns the route through this CRTC, or one without a plane if all its primary planes feed other CRTCs.
CrtcRoute route_through(const Card& card, std::uint32_t crtc_id, std::size_t index) {
  CrtcRoute route;
  const PlaneResources planes(drmModeGetPlaneResources(card.fd()));
  for (std::uint32_t i = 0; planes && i < planes->count_planes; ++i) {
    const KernelPlane plane(drmModeGetPlane(card.fd(), planes->planes[i]));
    if (!plane || (plane->possible_crtcs >> index & 1U) == 0) continue;
    if (plane->crtc_id != 0 && plane->crtc_id != crtc_id) continue;
    if (!is_primary(card.fd(), plane->plane_id)) continue;
    route.crtc_id = crtc_id;
    route.plane_id = plane->plane_id;
    route.formats.assign(plane->formats, plane->formats + plane->count_formats);
    return route;
  }
  return route;
}

}  // namespace

std::string describe_formats(const std::vector<std::uint32_t>& formats) {
  std::string text;
  for (const std::uint32_t format : formats) {
    if (!text.empty()) text += ' ';
    for (unsigned shift = 0; shift < 32; shift += 8) {
      const auto letter = static_cast<char>(format >> shift & 0x7f);
      if (letter != ' ') text += letter;  // short names are padded with blanks
    }
  }
  return text;
}

std::vector<CrtcRoute> routes_to(const Card& card, const Connector& connector) {
  const std::vector<Connector> all = card.connectors();
  const std::vector<std::uint32_t> crtcs = card.crtcs();
  // 0 for the connector's own CRTC, 1 for an idle one, 2 for another connector's.
  const auto rank = [&](const CrtcRoute& route) {
    if (route.crtc_id == connector.crtc_id) return 0;
    const bool idle = std::ranges::find(all, route.crtc_id, &Connector::crtc_id) == all.end();
    return idle ? 1 : 2;
  };
  std::vector<CrtcRoute> routes;
  for (std::size_t i = 0; i < crtcs.size(); ++i) {
    if ((connector.possible_crtcs >> i & 1U) == 0) continue;
    CrtcRoute route = route_through(card, crtcs[i], i);
    if (route.plane_id != 0) routes.push_back(std::move(route));
  }
  std::ranges::stable_sort(routes, {}, rank);
  if (routes.empty()) throw HardwareError("no CRTC can feed " + connector.name + " of " + card.name());
  return routes;
}

void check_format(const CrtcRoute& route, PixelFormat format, const std::string& output) {
  if (std::ranges::find(route.formats, fourcc_of(format)) != route.formats.end()) return;
  throw HardwareError(output + " does not support the pixel format " + describe_formats({fourcc_of(format)}) +
                      "; formats: " + describe_formats(route.formats));
}

}  // namespace contourd
