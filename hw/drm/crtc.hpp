// A CRTC in one mode, with its primary plane: it feeds one connector with pictures. One implementation uses
// the kernel's atomic calls, one the legacy calls; make_crtc() chooses. Not thread-safe.
// Calls return 0 or an errno; noexcept calls do not allocate either. A picture is given as a framebuffer's
// id.
#pragma once

#include <cstdint>
#include <memory>

#include "hw/drm/card.hpp"
#include "hw/drm/connector.hpp"
#include "hw/drm/mode.hpp"
#include "hw/interface.hpp"

namespace contourd {

// The destructor leaves the output as it is.
class Crtc : public Interface {
 public:
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

// Returns an atomic CRTC if `legacy` is false, the driver supports atomic calls and a test commit of the mode
// with this picture succeeds; otherwise a legacy one. Changes nothing on the screen. A card that is not DRM
// master cannot run the test and gets a legacy CRTC. The card must outlive the CRTC. Throws HardwareError.
[[nodiscard]] std::unique_ptr<Crtc> make_crtc(const Card& card, const Connector& connector, const Mode& mode,
                                              std::uint32_t picture, bool legacy);

}  // namespace contourd
