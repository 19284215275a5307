// A CRTC in one mode, with its primary plane: it feeds one connector with pictures. One implementation uses
// the kernel's atomic calls, one the legacy calls; make_crtc() in crtc_choice.hpp chooses. Not thread-safe.
// Calls return 0 or an errno; noexcept calls do not allocate either. A picture is given as a framebuffer's
// id.
#pragma once

#include <cstdint>

namespace contourd {

class Crtc {
 public:
  Crtc() = default;
  Crtc(const Crtc&) = delete;
  Crtc& operator=(const Crtc&) = delete;
  virtual ~Crtc() = default;  // leaves the output as it is

  [[nodiscard]] virtual std::uint32_t id() const noexcept = 0;
  [[nodiscard]] virtual bool is_atomic() const noexcept = 0;

  // Returns 0 if the driver would accept the mode with this picture or cannot say. Does not change the
  // screen.
  [[nodiscard]] virtual int test_mode(std::uint32_t picture) noexcept = 0;
  // Sets the mode; the picture is on the screen when the call returns. Waits for pending commits: at most two
  // refreshes, but if the driver hangs 10 s for each event that the kernel waits for.
  [[nodiscard]] virtual int set_mode(std::uint32_t picture) noexcept = 0;
  // Requests the picture from the next refresh on and returns at once. When the picture is on the screen, an
  // event with `serial` (user_data in struct drm_event_vblank) can be read from the card's descriptor.
  // Returns EBUSY while an earlier flip is pending.
  [[nodiscard]] virtual int flip(std::uint32_t picture, std::uint64_t serial) noexcept = 0;
  // Ends the signal. May block as long as set_mode().
  virtual int turn_off() noexcept = 0;
};

}  // namespace contourd
