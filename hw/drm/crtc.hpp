// What feeds one connector with pictures: a CRTC in one mode, with its primary plane. Two kinds, by the
// kernel's atomic or legacy calls; make_crtc() of crtc_choice.hpp chooses. Not thread-safe. Calls return 0 or
// an errno, and those that are noexcept neither allocate nor throw. A picture is a framebuffer's id.
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

  // Whether the driver would take the mode with this picture; what is on the screen stays. 0 where the driver
  // cannot say.
  [[nodiscard]] virtual int test_mode(std::uint32_t picture) noexcept = 0;
  // Sets the mode, with this picture on the screen when it returns. Waits for whatever is pending: two
  // refreshes at most, 10 s for each thing that the kernel waits for when the driver hangs.
  [[nodiscard]] virtual int set_mode(std::uint32_t picture) noexcept = 0;
  // Asks for the picture from the next refresh on and returns at once; the card's descriptor then gives an
  // event with `serial` (struct drm_event_vblank's user_data). EBUSY while an earlier one waits.
  [[nodiscard]] virtual int flip(std::uint32_t picture, std::uint64_t serial) noexcept = 0;
  // No signal. May wait as set_mode().
  virtual int turn_off() noexcept = 0;
};

}  // namespace contourd
