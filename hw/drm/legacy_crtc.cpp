#include "hw/drm/legacy_crtc.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cerrno>

namespace contourd {

LegacyCrtc::LegacyCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode)
    : fd_(card.fd()),
      id_(route.crtc_id),
      connector_id_(connector.id),
      mode_(mode),
      changes_(changes_to_neutral(ObjectProperties(fd_, id_, DRM_MODE_OBJECT_CRTC),
                                  ObjectProperties(fd_, connector_id_, DRM_MODE_OBJECT_CONNECTOR))) {}

int LegacyCrtc::set_mode(std::uint32_t picture) noexcept {
  // Removes another program's cursor; the error for a CRTC without one is ignored.
  drmModeSetCursor(fd_, id_, 0, 0, 0);
  // Errors are ignored here: settle_color() finds them when it reads the properties back.
  for (const PropertyChange& change : changes_)
    drmModeObjectSetProperty(fd_, change.object, change.type, change.property, change.value);
  return -drmModeSetCrtc(fd_, id_, picture, 0, 0, &connector_id_, 1, &mode_);
}

int LegacyCrtc::flip(std::uint32_t picture, std::uint64_t serial) noexcept {
  // Does the same as drmModePageFlip(), which would take the serial as a pointer.
  drm_mode_crtc_page_flip flip{};
  flip.crtc_id = id_;
  flip.fb_id = picture;
  flip.flags = DRM_MODE_PAGE_FLIP_EVENT;
  flip.user_data = serial;
  return drmIoctl(fd_, DRM_IOCTL_MODE_PAGE_FLIP, &flip) == 0 ? 0 : errno;
}

int LegacyCrtc::turn_off() noexcept {
  return -drmModeSetCrtc(fd_, id_, 0, 0, 0, nullptr, 0, nullptr);
}

}  // namespace contourd
