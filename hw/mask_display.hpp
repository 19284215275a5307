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
  // REQUIRES: the mask has the display's size; no other show() or black() is waiting for its `done`.
  virtual void show(const Mask& mask, Presented done) = 0;

  // Puts black on the screen at the next refresh. Returns at once.
  // REQUIRES: no other show() or black() is waiting for its `done`.
  virtual void black(Presented done) = 0;

  // Black from the next refresh on, whatever else was asked; a waiting `done` is dropped. The way out of
  // everything.
  virtual void black_now() noexcept = 0;

  // Begins to look whether a display that is not ready is back; it is told as a recovery. Does not block.
  virtual void look_again() = 0;

  // For another process: what makes the screen black. Nothing while there is no such thing.
  [[nodiscard]] virtual LightDisplayPath black_path() const = 0;
};

}  // namespace contourd
