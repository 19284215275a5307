// A CRTC that is driven by the kernel's atomic calls. Not thread-safe.
#pragma once

#include "hw/drm/atomic_request.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/crtc_route.hpp"

namespace contourd {

// The kernel's copy of a mode, whose id is the value of a CRTC's MODE_ID property.
class ModeBlob {
 public:
  // Throws HardwareError.
  ModeBlob(const Card& card, const Mode& mode);
  ~ModeBlob();
  ModeBlob(const ModeBlob&) = delete;
  ModeBlob& operator=(const ModeBlob&) = delete;

  [[nodiscard]] std::uint32_t id() const { return id_; }

 private:
  int fd_;
  std::uint32_t id_ = 0;
};

class AtomicCrtc final : public Crtc {
 public:
  // Throws HardwareError if the kernel rejects the mode, as it does for a card without DRM_CLIENT_CAP_ATOMIC.
  // The card must outlive this object.
  AtomicCrtc(const Card& card, const Connector& connector, const CrtcRoute& route, const Mode& mode);

  [[nodiscard]] std::uint32_t id() const noexcept override { return id_; }
  [[nodiscard]] bool is_atomic() const noexcept override { return true; }
  [[nodiscard]] int test_mode(std::uint32_t picture) noexcept override;
  [[nodiscard]] int set_mode(std::uint32_t picture) noexcept override;
  [[nodiscard]] int flip(std::uint32_t picture, std::uint64_t serial) noexcept override;
  int turn_off() noexcept override;

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

}  // namespace contourd
