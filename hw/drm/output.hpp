// A connector in one mode with the pictures that it shows: black, and two or three masks by turns. Black from
// its construction on; black, then off, when it goes, so that nobody's former picture (a console, a desktop)
// comes back as light. Not thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mask.hpp"
#include "hw/clock.hpp"
#include "hw/drm/card.hpp"
#include "hw/drm/crtc.hpp"
#include "hw/drm/dumb_buffer.hpp"

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
  [[nodiscard]] bool is_atomic() const { return crtc_->is_atomic(); }
  // The connector as it is now. Asks the display, some milliseconds.
  [[nodiscard]] Connector connector() const;

  // Writes the mask where the screen does not look, for show_written(). Returns the bytes written.
  // REQUIRES: the mask has the mode's size; show_written() or black_now() since the last write.
  std::size_t write(const Mask& mask) noexcept;
  // The picture for the next refresh, or for the one after a flip that is still waiting. Returns 0 or an
  // errno.
  [[nodiscard]] int show_written() noexcept;
  [[nodiscard]] int show_black() noexcept;
  // Black whatever is waiting. Blocks for two refreshes at most when a flip is (10 s if the driver hangs).
  void black_now() noexcept;

  struct Events {
    bool card_is_gone = false;
    int error = 0;                   // of a flip that waited for its turn
    std::optional<TimePoint> shown;  // the last picture asked for is on the screen since then
  };
  // To be called when the card's descriptor can be read.
  [[nodiscard]] Events read_events() noexcept;

  // Sets the mode anew, black, after the display was unplugged or another program had the card. False while
  // the display is not connected. Throws HardwareError.
  [[nodiscard]] bool relight(const DrmDisplayConfig& config);
  // No signal, until relight(); black in place where the kernel refuses (this process is not DRM master).
  void turn_off() noexcept;

 private:
  struct Flip {
    const Framebuffer* picture = nullptr;
    std::uint64_t serial = 0;
  };

  void set_mode(const Connector& connector, const DrmDisplayConfig& config);
  [[nodiscard]] Framebuffer& writable_mask() noexcept;
  [[nodiscard]] int show(const Framebuffer& picture) noexcept;
  void blacken_masks_after(int error) noexcept;
  void now_on_screen(const Framebuffer& picture) noexcept;
  void finish_flip(std::uint64_t serial, TimePoint when, Events& events) noexcept;

  Card card_;
  std::uint32_t connector_id_;
  std::string name_;
  Mode mode_{};
  bool monotonic_;
  std::unique_ptr<Framebuffer> black_;
  std::vector<std::unique_ptr<Framebuffer>> masks_;
  std::unique_ptr<Crtc> crtc_;

  const Framebuffer* on_screen_ = nullptr;
  const Framebuffer* before_ = nullptr;  // what was on the screen before that
  const Framebuffer* written_ = nullptr;
  const Framebuffer* next_ = nullptr;  // asked for while a flip was waiting
  std::optional<Flip> flip_;           // waiting for its refresh
  std::uint64_t serial_ = 0;
};

}  // namespace contourd
