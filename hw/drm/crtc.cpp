#include "hw/drm/crtc.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "hw/drm/atomic_request.hpp"
#include "hw/drm/color.hpp"
#include "hw/drm/crtc_route.hpp"
#include "hw/hardware_error.hpp"
#include "hw/owned.hpp"

namespace contourd {
namespace {

using PlaneResources = Owned<drmModePlaneRes, drmModeFreePlaneResources>;

std::uint64_t fixed_point(std::uint16_t pixels) {
  return static_cast<std::uint64_t>(pixels) << 16;  // 16.16, the format of source rectangles
}

// The kernel's copy of a mode, whose id is the value of a CRTC's MODE_ID property.
class ModeBlob {
 public:
  // Throws HardwareError.
  ModeBlob(const Card& card, const Mode& mode) : fd_(card.fd()) {
    const int result = drmModeCreatePropertyBlob(fd_, &mode, sizeof mode, &id_);
    if (result != 0) throw HardwareError(card.name() + " rejected the mode: " + std::strerror(-result));
  }
  ~ModeBlob() { drmModeDestroyPropertyBlob(fd_, id_); }
  ModeBlob(const ModeBlob&) = delete;
  ModeBlob& operator=(const ModeBlob&) = delete;

  [[nodiscard]] std::uint32_t id() const { return id_; }

 private:
  int fd_;
  std::uint32_t id_ = 0;
};

// A CRTC that is driven by the kernel's atomic calls.
class AtomicCrtc final : public Crtc {
 public:
  // Throws HardwareError if the kernel rejects the mode, as it does for a card without DRM_CLIENT_CAP_ATOMIC.
  // The card must outlive this object.
  AtomicCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode);

  [[nodiscard]] std::uint32_t id() const noexcept override { return id_; }
  [[nodiscard]] bool is_atomic() const noexcept override { return true; }
  [[nodiscard]] int test_mode(std::uint32_t picture) noexcept override {
    set_mode_.change_last(picture);
    return set_mode_.commit(fd_, DRM_MODE_ATOMIC_TEST_ONLY | DRM_MODE_ATOMIC_ALLOW_MODESET);
  }
  [[nodiscard]] int set_mode(std::uint32_t picture) noexcept override {
    set_mode_.change_last(picture);
    return set_mode_.commit(fd_, DRM_MODE_ATOMIC_ALLOW_MODESET);
  }
  [[nodiscard]] int flip(std::uint32_t picture, std::uint64_t serial) noexcept override {
    flip_.change_last(picture);
    return flip_.commit(fd_, DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, serial);
  }
  int turn_off() noexcept override { return turn_off_.commit(fd_, DRM_MODE_ATOMIC_ALLOW_MODESET); }

 private:
  void clear_the_way(const Card& card, const Connector& connector, const CrtcRoute& route);
  void add_neutral_values(const ObjectProperties& crtc, const ObjectProperties& connector,
                          const ObjectProperties& plane);

  int fd_;
  std::uint32_t id_;
  ModeBlob mode_;
  AtomicRequest set_mode_, flip_;  // the last value in each is the framebuffer
  AtomicRequest turn_off_;
};

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

// A CRTC that is driven by the kernel's legacy calls, which are older than the atomic ones.
class LegacyCrtc final : public Crtc {
 public:
  // The card must outlive this object.
  LegacyCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode)
      : fd_(card.fd()),
        id_(route.crtc_id),
        connector_id_(connector.id),
        mode_(mode),
        changes_(changes_to_neutral(ObjectProperties(fd_, id_, DRM_MODE_OBJECT_CRTC),
                                    ObjectProperties(fd_, connector_id_, DRM_MODE_OBJECT_CONNECTOR))) {}

  [[nodiscard]] std::uint32_t id() const noexcept override { return id_; }
  [[nodiscard]] bool is_atomic() const noexcept override { return false; }
  [[nodiscard]] int test_mode(std::uint32_t) noexcept override { return 0; }
  [[nodiscard]] int set_mode(std::uint32_t picture) noexcept override {
    // Removes another program's cursor; the error for a CRTC without one is ignored.
    drmModeSetCursor(fd_, id_, 0, 0, 0);
    // Errors are ignored here: settle_color() finds them when it reads the properties back.
    for (const PropertyChange& change : changes_)
      drmModeObjectSetProperty(fd_, change.object, change.type, change.property, change.value);
    return -drmModeSetCrtc(fd_, id_, picture, 0, 0, &connector_id_, 1, &mode_);
  }
  [[nodiscard]] int flip(std::uint32_t picture, std::uint64_t serial) noexcept override {
    // Does the same as drmModePageFlip(), which would take the serial as a pointer.
    drm_mode_crtc_page_flip flip{};
    flip.crtc_id = id_;
    flip.fb_id = picture;
    flip.flags = DRM_MODE_PAGE_FLIP_EVENT;
    flip.user_data = serial;
    return drmIoctl(fd_, DRM_IOCTL_MODE_PAGE_FLIP, &flip) == 0 ? 0 : errno;
  }
  int turn_off() noexcept override { return -drmModeSetCrtc(fd_, id_, 0, 0, 0, nullptr, 0, nullptr); }

 private:
  int fd_;
  std::uint32_t id_, connector_id_;
  Mode mode_;
  std::vector<PropertyChange> changes_;
};

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
