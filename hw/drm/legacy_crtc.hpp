// A CRTC that is driven by the kernel's legacy calls, which are older than the atomic ones. Not thread-safe.
#pragma once

#include <vector>

#include "hw/drm/color.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/crtc_route.hpp"

namespace contourd {

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

}  // namespace contourd
