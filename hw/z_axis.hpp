// The build plate's axis: a homed linear stage that moves to heights. Height 0 is the plate touching the
// vat's film; up is positive. Not thread-safe: calls and callbacks happen on the event loop's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/device.hpp"

namespace contourd {

enum class HomingResult {
  Homed,
  NoTrigger,    // the switch never closed over the whole travel
  StillClosed,  // the switch stayed closed after backing off
  WrongSwitch,  // the switch at the other end closed
  NoMovement,   // the encoder does not follow the motor
  Fault,        // a machine event says why (emergency stop, a line that cannot be set)
  Stopped,      // stop() came first
};
[[nodiscard]] std::string_view describe(HomingResult result);

enum class MoveResult {
  Reached,
  Stopped,        // stop() came first; the position is still known
  OutsideTravel,  // the target lies beyond the soft limits; nothing moved
  NotHomed,       // the position is unknown; nothing moved
  Fault,          // a machine event says why; the position is unknown
  AtSwitch,       // of a nudge: the limit switch closed, or was closed on the way to it
};
[[nodiscard]] std::string_view describe(MoveResult result);

// Steps that were made too late, because the computer was too busy or is too slow.
struct LateSteps {
  std::uint64_t count = 0;  // steps that shifted all that came behind them
  Duration worst{};         // of any step
};

// An input as whoever wires it wants to see it.
struct AxisInputState {
  std::string name;  // "limit switch"
  std::string line;  // where it comes in: "line 23 of gpiochip0"
  std::optional<bool>
      active;               // switch reached, stop pressed, lid open, encoder high; none: it cannot be read
  std::uint64_t edges = 0;  // since the axis was opened, those that were too fast for the kernel left out
};

class LightCutoff;

class ZAxis : public Device {
 public:
  // Finds the limit switch in two passes and makes the position known. Returns at once; `done` is called from
  // the event loop. REQUIRES: not moving.
  virtual void home(std::function<void(HomingResult)> done) = 0;

  // Moves to `target` at no more than `speed`. Returns at once; `done` is called from the event loop, also
  // when nothing moved. REQUIRES: not moving.
  virtual void move_to(Nanometers target, MillimetersPerSecond speed,
                       std::function<void(MoveResult)> done) = 0;

  // Goes so far up, below 0 down, whether or not the position is known: which is unknown from then on. For an
  // axis that has yet to be wired rightly, so it ends where the limit switch closes, also when that is at the
  // wrong end. Returns at once; `done` is called from the event loop. REQUIRES: not moving; no further than
  // kLongestNudge.
  virtual void nudge(Nanometers distance, MillimetersPerSecond speed,
                     std::function<void(MoveResult)> done) = 0;

  // Decelerates to a standstill; the move's `done` gets Stopped. Does nothing when nothing moves.
  virtual void stop() = 0;

  // No further step from this instant; a waiting `done` is dropped. The position is unknown afterwards if a
  // move was under way.
  virtual void abort() noexcept = 0;

  // Takes the motor's current away: the plate can be turned by hand, may sink, and its position is unknown.
  // The next motion has it back. False, and nothing changed, where there is no line for that. REQUIRES: not
  // moving.
  virtual bool release() = 0;

  [[nodiscard]] virtual bool moving() const = 0;

  // Where the plate is: now, or at a time within the move under way. Nothing while the position is unknown.
  [[nodiscard]] virtual std::optional<Nanometers> height() const = 0;
  [[nodiscard]] virtual std::optional<Nanometers> height_at(TimePoint time) const = 0;

  // How much higher the last homing found the limit switch than the one before it did, by the steps made in
  // between; nothing when it did not come to its end, or the position was unknown before it.
  [[nodiscard]] virtual std::optional<Nanometers> homing_shift() const = 0;

  // The highest height that move_to accepts (soft limit); the lowest is 0.
  [[nodiscard]] virtual Nanometers travel() const = 0;

  // How long a move over `distance` takes: for progress and for motion timeouts.
  [[nodiscard]] virtual Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const = 0;

  // All inputs that are fitted, read now: some microseconds each.
  [[nodiscard]] virtual std::vector<AxisInputState> inputs() const = 0;

  // Of all moves since the axis was opened; none where no motor has to be stepped.
  [[nodiscard]] virtual LateSteps late_steps() const = 0;

  // The light that the emergency stop, the lid and inputs that cannot be read turn off, without waiting for
  // the event loop; null: none. It must outlive the axis, or be taken back before it goes.
  virtual void set_light_cutoff(LightCutoff* cutoff) noexcept = 0;
};

}  // namespace contourd
