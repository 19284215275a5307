// The projector's picture: one mask, or black. Not thread-safe: calls and callbacks happen on the event
// loop's thread.
#pragma once

#include <functional>
#include <optional>

#include "core/mask/mask.hpp"
#include "hw/clock.hpp"
#include "hw/device.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

class MaskDisplay : public Device {
 public:
  // Receives the time at which the picture really was on the screen (vblank), or nullopt if the display was
  // lost.
  using Presented = std::function<void(std::optional<TimePoint>)>;

  [[nodiscard]] virtual Pixels width() const = 0;
  [[nodiscard]] virtual Pixels height() const = 0;
  // Returns the time from one refresh to the next.
  [[nodiscard]] virtual Duration frame() const = 0;

  // Puts the mask on the screen at the next refresh. Returns at once and keeps no reference to the mask.
  // Drops the `done` of a show() or black() that is still pending. REQUIRES: the mask has the display's size.
  virtual void show(const Mask& mask, Presented done) = 0;

  // Puts black on the screen at the next refresh. Returns at once. Drops a pending `done`, like show().
  virtual void black(Presented done) = 0;

  // Keeps the screen black from the next refresh on, whatever else was requested, and drops a pending `done`.
  // Allowed in every state.
  virtual void black_now() noexcept = 0;

  // Probes for a display that is not ready, and reports a recovery if it is back. Does not block.
  virtual void probe_again() {}

  // Returns the handles with which another process can make the screen black; empty while there are none.
  [[nodiscard]] virtual LightDisplayPath black_path() const { return {}; }
};

}  // namespace contourd
