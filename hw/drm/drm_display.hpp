// A projector on one of the kernel's display outputs, by libdrm. Shows what it is told and nothing else:
// black from its construction on, black and no signal when it goes, no console, no cursor.
//
// A display that is unplugged, whose mode is gone, whose card another program took, or of which the kernel
// does not say in time that it shows a picture (flip_deadline()), is lost: a waiting `done` gets nothing, and
// a MachineEvent says why, within 20 ms while a mask is on the screen. It is taken up again, black, when the
// kernel says that it is back, or at probe_again(); show() and black() give nothing as long as it is lost.
//
// What blocks is done on a thread of its own: asking a display what it is, setting and ending its mode. So
// the event loop is held up by none of it, in an exposure or out of it, but for the constructor, which a
// machine calls while it has no display, and so no job and no light.
//
// Presented times are those of the vblank at whose end the screen began to show the picture (CLOCK_MONOTONIC,
// in whole microseconds); its last row follows a refresh later. Drivers without vblanks (virtio-gpu, bochs)
// give the time when they were done with the flip instead, and are not paced by the refresh.
//
// Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
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
  // Sets the mode, black. A display that is merely not connected is a lost one: why_not_ready() says so.
  // Throws HardwareError for what waiting does not mend: no such card, connector, mode or format, a card in
  // use, no permission. The watcher must outlive it. Blocks for some refreshes, and some milliseconds, 300
  // and more with some, for each connected display.
  DrmDisplay(DescriptorWatcher& watcher, const DrmDisplayConfig& config);
  ~DrmDisplay() override;

  [[nodiscard]] Pixels width() const override;
  [[nodiscard]] Pixels height() const override;
  // Of its mode; 0 before the display was there.
  [[nodiscard]] Duration frame() const override;

  // Neither allocates nor blocks.
  void show(const Mask& mask, Presented done) override;
  void black(Presented done) override;
  // Does not block: where a flip is waiting for its refresh black follows it, and a mask that it would bring
  // is blackened in its memory. A commit that waits for the driver (10 s and more, the kernel's limit, when
  // that hangs) would be no sooner.
  void black_now() noexcept override;

  // `call` runs when the display is lost, before its waiting `done`, and when it has been taken up again;
  // from the event loop.
  void on_event(std::function<void(const MachineEvent&)> call) override;

  // That another program gave the card back the kernel does not say.
  void probe_again() override;

  // Never for good: it is taken up again by itself.
  [[nodiscard]] bool lost() const override { return false; }
  // Why nothing can be shown: one sentence at most.
  [[nodiscard]] std::vector<std::string> why_not_ready() const override;
  // The text console could not be kept off, the driver changes what pixels mean.
  [[nodiscard]] std::vector<std::string> warnings() const override;
  // "HDMI-A-1 of /dev/dri/card0 (vc4): 1920x1080 at 60.00 Hz, atomic"
  [[nodiscard]] std::string description() const override;

  // Of the card, which is shared. Nothing while it is gone.
  [[nodiscard]] LightDisplayPath black_path() const override;

  // Written into the card's memory by the last show().
  [[nodiscard]] std::size_t bytes_written() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace contourd
