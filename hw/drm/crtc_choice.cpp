#include "hw/drm/crtc_choice.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cerrno>
#include <vector>

#include "hw/drm/atomic_crtc.hpp"
#include "hw/drm/color.hpp"
#include "hw/drm/crtc_route.hpp"

namespace contourd {
namespace {

// A CRTC that is driven by the kernel's legacy calls, which are older than the atomic ones.
class LegacyCrtc final : public Crtc {
 public:
  // The card must outlive this object.
  LegacyCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode);

  [[nodiscard]] std::uint32_t id() const noexcept override { return id_; }
  [[nodiscard]] bool is_atomic() const noexcept override { return false; }
  [[nodiscard]] int test_mode(std::uint32_t) noexcept override { return 0; }
  [[nodiscard]] int set_mode(std::uint32_t picture) noexcept override;
  [[nodiscard]] int flip(std::uint32_t picture, std::uint64_t serial) noexcept override;
  int turn_off() noexcept override;

 private:
  int fd_;
  std::uint32_t id_, connector_id_;
  Mode mode_;
  std::vector<PropertyChange> changes_;
};

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

}  // namespace

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
