// A projector on one of the kernel's display outputs, by libdrm. Shows what it is told and nothing else:
// black from its construction on, black and no signal when it goes, no console, no cursor.
//
// A display that is unplugged, whose mode is gone, or whose card another program took is lost: a waiting
// `done` gets nothing, and a Disturbance says why, within 20 ms while a mask is on the screen. It is taken up
// again, black, when the kernel says that it is back, at look_again(), or at the next show() or black();
// those get nothing as long as it is lost.
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

namespace contourd {

class DrmDisplay final : public MaskDisplay {
 public:
  // Sets the mode, black. A display that is merely not connected is a lost one: problem() says so. Throws
  // HardwareError for what waiting does not mend: no such card, connector, mode or format, a card in use, no
  // permission. The watcher must outlive it. Blocks for some refreshes, and some milliseconds for each
  // connected display.
  DrmDisplay(DescriptorWatcher& watcher, const DrmDisplayConfig& config);
  ~DrmDisplay() override;

  [[nodiscard]] Pixels width() const override;
  [[nodiscard]] Pixels height() const override;
  // Of its mode; 0 before the display was there.
  [[nodiscard]] Duration frame() const override;

  // Neither allocates nor blocks unless the display is lost; then it looks whether it is back.
  void show(const Mask& mask, Presented done) override;
  void black(Presented done) override;
  // Blocks for two refreshes at most when a mask is waiting for its refresh (10 s, the kernel's limit, if the
  // driver hangs).
  void black_now() noexcept override;

  // `call` runs when the display is lost, before its waiting `done`, and when the kernel's word that it is
  // back proves true; from the event loop.
  void on_disturbance(std::function<void(const Disturbance&)> call);

  // Whether a lost display is back, which it then is: on_disturbance()'s `call` runs. That another program
  // gave the card back the kernel does not say.
  void look_again();

  // Why nothing can be shown: one sentence. Nothing when all is well.
  [[nodiscard]] std::optional<std::string> problem() const;
  // What an owner should know though it works: one sentence. The text console could not be kept off.
  [[nodiscard]] std::optional<std::string> warning() const;
  // "HDMI-A-1 of /dev/dri/card0 (vc4): 1920x1080 at 60.00 Hz, atomic"
  [[nodiscard]] std::string description() const;

  // Written into the card's memory by the last show().
  [[nodiscard]] std::size_t bytes_written() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// What --check-hardware tells of an output.
struct DrmReport {
  std::string card, driver, connector, mode;
  std::string formats;                 // "XR24 RG16"
  std::optional<std::string> console;  // the text console on the same card: "/dev/fb0"
  std::optional<std::string> in_use;   // who has the card, so that the driver could not be asked
  bool atomic = false;
  bool vblank = false;  // the driver tells when a picture is on the screen
};

// Finds what a DrmDisplay would use and asks the driver whether it would do it; changes nothing on any
// screen. Throws HardwareError as DrmDisplay does, also when nothing is connected.
[[nodiscard]] DrmReport check_drm_display(const DrmDisplayConfig& config);
// One line.
[[nodiscard]] std::string describe(const DrmReport& report);

}  // namespace contourd
