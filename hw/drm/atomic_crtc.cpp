#include "hw/drm/atomic_crtc.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cstring>

#include "hw/drm/color.hpp"
#include "hw/drm/libdrm_pointer.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

using PlaneResources = LibdrmPointer<drmModePlaneRes, drmModeFreePlaneResources>;

std::uint64_t fixed_point(std::uint16_t pixels) {
  return static_cast<std::uint64_t>(pixels) << 16;  // 16.16, the format of source rectangles
}

}  // namespace

ModeBlob::ModeBlob(const Card& card, const Mode& mode) : fd_(card.fd()) {
  const int result = drmModeCreatePropertyBlob(fd_, &mode, sizeof mode, &id_);
  if (result != 0) throw HardwareError(card.name() + " rejected the mode: " + std::strerror(-result));
}

ModeBlob::~ModeBlob() {
  drmModeDestroyPropertyBlob(fd_, id_);
}

AtomicCrtc::AtomicCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode)
    : fd_(card.fd()), id_(route.crtc_id), mode_(card, mode) {
  const ObjectProperties on(fd_, connector.id, DRM_MODE_OBJECT_CONNECTOR);
  const ObjectProperties crtc(fd_, route.crtc_id, DRM_MODE_OBJECT_CRTC);
  const ObjectProperties plane(fd_, route.plane_id, DRM_MODE_OBJECT_PLANE);

  clear_the_way(card, connector, route);
  set_mode_.set(on, "CRTC_ID", route.crtc_id);
  set_mode_.set(crtc, "MODE_ID", mode_.id());
  set_mode_.set(crtc, "ACTIVE", 1);
  add_neutral_values(crtc, on, plane);
  set_mode_.set(plane, "CRTC_ID", route.crtc_id);
  for (const char* origin : {"SRC_X", "SRC_Y", "CRTC_X", "CRTC_Y"})
    set_mode_.set(plane, origin, 0);
  set_mode_.set(plane, "SRC_W", fixed_point(mode.hdisplay));
  set_mode_.set(plane, "SRC_H", fixed_point(mode.vdisplay));
  set_mode_.set(plane, "CRTC_W", mode.hdisplay);
  set_mode_.set(plane, "CRTC_H", mode.vdisplay);
  set_mode_.set(plane, "FB_ID", 0);

  flip_.set(plane, "FB_ID", 0);

  turn_off_.set(on, "CRTC_ID", 0);
  turn_off_.set(crtc, "MODE_ID", 0);
  turn_off_.set(crtc, "ACTIVE", 0);
  turn_off_.set(plane, "CRTC_ID", 0);
  turn_off_.set(plane, "FB_ID", 0);
}

// Removes leftovers of other programs from this CRTC: a cursor, an overlay, a second connector.
void AtomicCrtc::clear_the_way(const Card& card, const Connector& connector, const CrtcRoute& route) {
  for (const Connector& other : card.connectors()) {
    if (other.id == connector.id || other.crtc_id != route.crtc_id) continue;
    set_mode_.set(ObjectProperties(fd_, other.id, DRM_MODE_OBJECT_CONNECTOR), "CRTC_ID", 0);
  }
  const PlaneResources planes(drmModeGetPlaneResources(fd_));
  for (std::uint32_t i = 0; planes && i < planes->count_planes; ++i) {
    const ObjectProperties plane(fd_, planes->planes[i], DRM_MODE_OBJECT_PLANE);
    const auto crtc = plane.find("CRTC_ID");
    if (plane.object() == route.plane_id || !crtc || crtc->value != route.crtc_id) continue;
    set_mode_.set(plane, "CRTC_ID", 0);
    set_mode_.set(plane, "FB_ID", 0);
  }
}

// Lets pixels pass unchanged: no gamma or colour matrix, full range, no margins, upright and opaque.
void AtomicCrtc::add_neutral_values(const ObjectProperties& crtc, const ObjectProperties& connector,
                                    const ObjectProperties& plane) {
  for (const PropertyChange& change : changes_to_neutral(crtc, connector))
    set_mode_.set(change.object, change.property, change.value);
  for (const char* margin : {"left margin", "right margin", "top margin", "bottom margin"})
    set_mode_.set_if_other(connector, margin, 0);
  set_mode_.set_if_other(plane, "rotation", DRM_MODE_ROTATE_0);
  set_mode_.set_if_other(plane, "alpha", 0xffff);
}

int AtomicCrtc::test_mode(std::uint32_t picture) noexcept {
  set_mode_.change_last(picture);
  return set_mode_.commit(fd_, DRM_MODE_ATOMIC_TEST_ONLY | DRM_MODE_ATOMIC_ALLOW_MODESET);
}

int AtomicCrtc::set_mode(std::uint32_t picture) noexcept {
  set_mode_.change_last(picture);
  return set_mode_.commit(fd_, DRM_MODE_ATOMIC_ALLOW_MODESET);
}

int AtomicCrtc::flip(std::uint32_t picture, std::uint64_t serial) noexcept {
  flip_.change_last(picture);
  return flip_.commit(fd_, DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, serial);
}

int AtomicCrtc::turn_off() noexcept {
  return turn_off_.commit(fd_, DRM_MODE_ATOMIC_ALLOW_MODESET);
}

}  // namespace contourd
