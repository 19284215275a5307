// A connector in one mode with the pictures that it shows: black, and two or three masks in turn. An output
// is black from construction on. Its destructor makes it black, then off, so that no earlier picture (a
// console, a desktop) comes back as light. Not thread-safe except where noted; may be handed from one thread
// to another.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mask/mask.hpp"
#include "hw/clock.hpp"
#include "hw/drm/card.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/drm/dumb_buffer.hpp"
#include "hw/drm/page_flips.hpp"

namespace contourd {

class Output {
 public:
  // Becomes DRM master and sets the mode, which blocks for some refreshes. Throws HardwareError.
  Output(Card card, const Connector& connector, const DrmDisplayConfig& config);
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  // "HDMI-A-1 of /dev/dri/card0 (vc4)"
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Card& card() const { return card_; }
  [[nodiscard]] const Mode& mode() const { return mode_; }
  [[nodiscard]] Duration frame() const;  // the refresh period
  // The ids that the kernel needs to show black.
  [[nodiscard]] std::uint32_t crtc_id() const { return crtc_->id(); }
  [[nodiscard]] std::uint32_t black_id() const { return black_->id(); }
  [[nodiscard]] bool is_atomic() const { return crtc_->is_atomic(); }
  [[nodiscard]] std::uint32_t connector_id() const { return connector_id_; }
  // Reads the connector's present state. Asks the display, which takes some milliseconds, with some displays
  // 300 or more. May be called from any thread.
  [[nodiscard]] Connector connector() const { return card_.connector(connector_id_); }
  // Returns a sentence for each change that the driver makes to pixels and that could not be switched off.
  [[nodiscard]] const std::vector<std::string>& color_warnings() const { return color_warnings_; }

  // Writes the mask into a buffer that is not on the screen, for show_written(). Overwrites a mask that was
  // written but not shown. REQUIRES: the mask has the mode's size.
  void write(const Mask& mask) noexcept;
  // show_written() and show_black() request the picture for the next refresh, or for the refresh after a flip
  // that is still pending. They return 0 or an errno.
  [[nodiscard]] int show_written() noexcept;
  [[nodiscard]] int show_black() noexcept;
  // Makes the screen black whatever is pending. Does not block: a mask whose flip is pending is blackened in
  // its memory, and so are all masks if the kernel refuses the flip to black. Returns 0 or an errno.
  int black_now() noexcept;
  // True if the kernel has not confirmed a flip within flip_deadline().
  [[nodiscard]] bool flip_is_overdue() const noexcept;
  [[nodiscard]] bool flip_waits() const noexcept { return flips_.waiting_since().has_value(); }

  struct Events {
    bool card_is_gone = false;
    int error = 0;                   // the errno of a flip that was queued
    std::optional<TimePoint> shown;  // since when the last requested picture has been on the screen
  };
  // To be called when the card's descriptor is readable.
  [[nodiscard]] Events read_events() noexcept;

  // Sets the mode again, black, after the display was unplugged, another program had the card, or the kernel
  // did not confirm a flip. Returns false if the display is not connected. May block for 300 ms or more, and
  // for 10 s or more if the driver hangs. Throws HardwareError, also if the kernel then does not show black.
  [[nodiscard]] bool restore(const DrmDisplayConfig& config);
  // Ends the signal until restore(). If the kernel refuses (this process is not DRM master), the masks are
  // blackened in their memory instead. May block as long as restore().
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

// The result of a probe for a display. A probe blocks for up to 300 ms or more, and for 10 s or more if the
// driver hangs. Any thread.
struct DisplayProbe {
  std::shared_ptr<Output> output;  // black if is_back, else off; null if there is no output
  bool is_back = false;
  std::string refusal{};  // a sentence if the display is connected but cannot be used
  std::optional<std::string> console_warning{};
};

// Restores an output that was lost. The caller must not share it with another thread.
[[nodiscard]] DisplayProbe restored(std::shared_ptr<Output> output, const DrmDisplayConfig& config);

// Opens the display that the config selects. Returns no output if none is connected or its card is not ready
// yet.
[[nodiscard]] DisplayProbe probe_all(const DrmDisplayConfig& config);

// Blackens the text console and opens the output. Throws HardwareError.
[[nodiscard]] DisplayProbe open_display(FoundOutput found, const DrmDisplayConfig& config);

// The kernel's text console on a card's outputs. While this process lives, DRM master keeps the console off
// the screen; when the process dies, the kernel shows the console's picture again, as light. So the picture
// is made black and the console is set to draw no text. Both deliberately outlast this process. They do not
// cover a switch to another terminal, or a login prompt that restarts (getty sets its terminal to text mode):
// booting with fbcon=map:9 keeps the console off the outputs for good.

// Returns the device of the console on that card ("/dev/fb0"), or nullopt if the card has none.
[[nodiscard]] std::optional<std::filesystem::path> console_of(const std::filesystem::path& card);

// Puts the active virtual terminal into graphics mode (KD_GRAPHICS: ioctl_console(2)), in which the kernel
// draws no text, and overwrites the console's picture with black. Does nothing on a card without a console.
// Returns a sentence, with what the operator can do, if the console could not be kept off.
[[nodiscard]] std::optional<std::string> keep_console_dark(const std::filesystem::path& card);

}  // namespace contourd
