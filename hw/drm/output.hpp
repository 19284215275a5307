// A connector in one mode with the pictures that it shows: black, and two or three masks by turns. Black from
// its construction on; black, then off, when it goes, so that nobody's former picture (a console, a desktop)
// comes back as light. Not thread-safe but where it says so; may be handed from one thread to another.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mask/mask.hpp"
#include "hw/clock.hpp"
#include "hw/drm/card.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/dumb_buffer.hpp"
#include "hw/drm/page_flips.hpp"

namespace contourd {

class Output {
 public:
  // Becomes DRM master and sets the mode. Blocks for as long as that takes (some refreshes). Throws
  // HardwareError.
  Output(Card card, const Connector& connector, const DrmDisplayConfig& config);
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  // "HDMI-A-1 of /dev/dri/card0 (vc4)"
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Card& card() const { return card_; }
  [[nodiscard]] const Mode& mode() const { return mode_; }
  [[nodiscard]] Duration frame() const;  // from one refresh to the next
  // What the kernel needs to show black.
  [[nodiscard]] std::uint32_t crtc_id() const { return crtc_->id(); }
  [[nodiscard]] std::uint32_t black_id() const { return black_->id(); }
  [[nodiscard]] bool is_atomic() const { return crtc_->is_atomic(); }
  [[nodiscard]] std::uint32_t connector_id() const { return connector_id_; }
  // The connector as it is now. Asks the display, some milliseconds, 300 and more with some. From any thread.
  [[nodiscard]] Connector connector() const;
  // A sentence for each thing that the driver does to the pixels and that could not be changed.
  [[nodiscard]] const std::vector<std::string>& color_warnings() const { return color_warnings_; }

  // Writes the mask where the screen does not look, for show_written(). Returns the bytes written.
  // One that was written and not shown is written over. REQUIRES: the mask has the mode's size.
  std::size_t write(const Mask& mask) noexcept;
  // The picture for the next refresh, or for the one after a flip that is still waiting. Returns 0 or an
  // errno.
  [[nodiscard]] int show_written() noexcept;
  [[nodiscard]] int show_black() noexcept;
  // Black whatever is waiting. Does not block: a mask whose flip is under way is blackened where it is, and
  // all masks where the kernel refuses. Returns 0 or an errno.
  int black_now() noexcept;
  // The kernel has not said for too long that a flip is done.
  [[nodiscard]] bool flip_is_overdue() const noexcept;
  [[nodiscard]] bool flip_waits() const noexcept { return flips_.waiting_since().has_value(); }

  struct Events {
    bool card_is_gone = false;
    int error = 0;                   // of a flip that waited for its turn
    std::optional<TimePoint> shown;  // the last picture asked for is on the screen since then
  };
  // To be called when the card's descriptor can be read.
  [[nodiscard]] Events read_events() noexcept;

  // Sets the mode anew, black, after the display was unplugged, another program had the card, or the kernel
  // did not say that a flip was done. False while the display is not connected. May block for 300 ms and
  // more, and for 10 s and more when the driver hangs. Throws HardwareError, also when the kernel does not
  // show black then.
  [[nodiscard]] bool restore(const DrmDisplayConfig& config);
  // No signal, until restore(); black in place where the kernel refuses (this process is not DRM master). May
  // block as restore().
  void turn_off() noexcept;

 private:
  void set_mode(const Connector& connector, const DrmDisplayConfig& config);
  void blacken_masks_after(int error) noexcept;
  void blacken_masks() noexcept;

  Card card_;
  std::uint32_t connector_id_;
  std::string name_;
  Mode mode_{};
  bool monotonic_;
  std::unique_ptr<Framebuffer> black_;
  std::vector<std::unique_ptr<Framebuffer>> masks_;
  std::unique_ptr<Crtc> crtc_;
  std::vector<std::string> color_warnings_;
  PageFlips flips_{0, {}};
};

}  // namespace contourd
