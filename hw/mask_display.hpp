// What the projector shows: one mask, or black. Not thread-safe: calls and callbacks happen on the event
// loop's thread.
#pragma once

#include <functional>
#include <optional>

#include "core/mask/mask.hpp"
#include "hw/clock.hpp"
#include "hw/device.hpp"
#include "hw/watchdog/device_paths.hpp"

namespace contourd {

class MaskDisplay : public Device {
 public:
  // When the picture really was on the screen (vblank time), or nothing when the display was lost.
  using Presented = std::function<void(std::optional<TimePoint>)>;

  [[nodiscard]] virtual Pixels width() const = 0;
  [[nodiscard]] virtual Pixels height() const = 0;
  // From one refresh to the next.
  [[nodiscard]] virtual Duration frame() const = 0;

  // Puts the mask on the screen at the next refresh. Returns at once and keeps no reference to the mask.
  // The `done` of a show() or black() that still waits is dropped. REQUIRES: the mask has the display's size.
  virtual void show(const Mask& mask, Presented done) = 0;

  // Puts black on the screen at the next refresh. Returns at once.
  // The same of a `done` that still waits.
  virtual void black(Presented done) = 0;

  // Black from the next refresh on, whatever else was asked; a waiting `done` is dropped. The way out of
  // everything.
  virtual void black_now() noexcept = 0;

  // Probes for a display that is not ready. One that is back is reported as a recovery. Does not block.
  virtual void probe_again() = 0;

  // What another process can make the screen black by. Empty while there is nothing.
  [[nodiscard]] virtual LightDisplayPath black_path() const = 0;
};

}  // namespace contourd
