// A projector on one of the kernel's display outputs, through libdrm. The output shows only the masks that
// it is given: black from construction on, black and then no signal at destruction, no console, no cursor.
//
// A display is lost if it is unplugged, its mode disappears, another program takes its card, or the kernel
// does not confirm a page flip in time (flip_deadline()). Then a pending `done` gets nullopt and a
// MachineEvent says why, within 20 ms while a mask is on the screen. The display is restored, black, when the
// kernel announces it again or at probe_again(). While it is lost, show() and black() call their `done` with
// nullopt.
//
// Calls that block (reading a display's EDID, setting and ending its mode) run on a thread of their own, so
// the event loop is not delayed by them, during an exposure or at any other time. The exception is the
// constructor: a machine calls it while it has no display, and so no job and no light.
//
// A presented time is that of the vblank at whose end the screen began to show the picture (CLOCK_MONOTONIC,
// in whole microseconds); the picture's last row follows a refresh later. Drivers without vblanks
// (virtio-gpu, bochs) report when they had processed the flip instead, and do not wait for the refresh.
//
// Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hw/descriptor_watcher.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/machine.hpp"
#include "hw/mask_display.hpp"
#include "hw/watchdog/light_watchdog.hpp"

namespace contourd {

class DrmDisplay final : public MaskDisplay {
 public:
  // Sets the mode, with a black picture. A display that is merely not connected counts as lost:
  // why_not_ready() says so. Throws HardwareError for an error that waiting does not fix: no such card,
  // connector, mode or format, a card in use, no permission. The watcher must outlive this object. Blocks for
  // some refreshes, and for some milliseconds (with some displays 300 or more) per connected display.
  DrmDisplay(DescriptorWatcher& watcher, const DrmDisplayConfig& config);
  ~DrmDisplay() override;

  [[nodiscard]] Pixels width() const override;
  [[nodiscard]] Pixels height() const override;
  // Returns the refresh period of the mode; 0 before a display was found.
  [[nodiscard]] Duration frame() const override;

  // Neither show() nor black() allocates or blocks.
  void show(const Mask& mask, Presented done) override;
  void black(Presented done) override;
  // Does not block. If a flip is pending, black follows it, and a mask that the flip would show is blackened
  // in its memory. A commit that waits for the driver (10 s or more, the kernel's limit, if the driver hangs)
  // would not be faster.
  void black_now() noexcept override;

  // `call` runs from the event loop: when the display is lost, before its pending `done`, and when it has
  // been restored.
  void on_event(std::function<void(const MachineEvent&)> call) override;

  // Needed because the kernel does not notify us when another program drops DRM master.
  void probe_again() override;

  // Returns at most one sentence: why nothing can be shown.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  // Returns a sentence if the text console may come back, and one for each change that the driver makes to
  // pixel values.
  [[nodiscard]] std::vector<std::string> warnings() const override;
  // "HDMI-A-1 of /dev/dri/card0 (vc4): 1920x1080 at 60.00 Hz, atomic"
  [[nodiscard]] std::string description() const override;

  // Returns the card's descriptor, which is shared, and the ids for showing black. Empty while there is no
  // output.
  [[nodiscard]] LightDisplayPath black_path() const override;

  // Returns the number of bytes that the last show() wrote into the card's memory.
  [[nodiscard]] std::size_t bytes_written() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace contourd
