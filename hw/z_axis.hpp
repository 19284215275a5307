// The build plate's axis: a homed linear stage that moves to heights. Height 0 is the plate touching the
// vat's film; up is positive. Not thread-safe: calls and callbacks happen on the event loop's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/continuous/rise_plan.hpp"
#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/device.hpp"
#include "hw/enum_names.hpp"

namespace contourd {

enum class HomingResult {
  Homed,
  NoTrigger,    // the switch never closed over the whole travel
  StillClosed,  // the switch stayed closed after backing off
  WrongSwitch,  // the switch at the other end closed
  NoMovement,   // the encoder does not follow the motor
  Fault,        // a machine event says why (emergency stop, a line that cannot be set)
  Stopped,      // stop() came first
  Resistance,   // the plate met resistance on its way down; it rests there
};
template <>
inline constexpr auto kNames<HomingResult> = names_to<HomingResult::Resistance>(
    "homed, the limit switch did not trigger after the full travel, "
    "the limit switch is still closed after backing off, "
    "the switch at the other end closed: the motor may turn the wrong way, "
    "the encoder does not follow the motor, a fault ended homing, homing was stopped, "
    "resistance stopped the plate on its way down");

enum class MoveResult {
  Reached,
  Stopped,        // stop() came first; the position is still known
  OutsideTravel,  // the target lies beyond the soft limits; nothing moved
  NotHomed,       // the position is unknown; nothing moved
  Fault,          // a machine event says why; the position is unknown
  AtSwitch,       // a nudge met the limit switch: it closed, or was closed already on the way towards it
  PlanRefused,    // the axis cannot follow the plan of a rise; nothing moved
  Resistance,     // the plate met resistance on its way down and rests there; a known position stays known
};
template <>
inline constexpr auto kNames<MoveResult> = names_to<MoveResult::Resistance>(
    "reached, the move was stopped, the target lies outside the travel, "
    "the position is unknown; home first, a fault ended the move, the limit switch is reached, "
    "the axis cannot follow the planned rise, the plate met resistance on its way down");

// Steps that were made too late, because the computer was too busy or is too slow.
struct LateSteps {
  std::uint64_t count = 0;  // steps so late that all later steps had to be shifted
  Duration worst{};         // the longest delay of any step
};

// A change of the force on the plate that has lasted for the debounce time.
struct ForceChange {
  bool active = false;                 // the force exceeds the threshold
  std::optional<Nanometers> height{};  // of the plate at that time; nullopt while it is unknown
};

// The force line's name among the inputs.
inline constexpr const char* kForceInput = "force";

// The state of an input, for the person who wires it.
struct AxisInputState {
  std::string name;            // "limit switch"
  std::string line;            // "line 23 of gpiochip0"
  std::optional<bool> active;  // switch reached, stop pressed, lid open, power failing, force, encoder high;
                               // nullopt if unreadable
  std::uint64_t edges = 0;     // since the axis was opened, without those too fast for the kernel
};

// Distances that an axis, real or simulated, moves while its position is unknown: in homing, and by hand.

// Distance by which homing backs off from the switch before the slow second pass (Klipper's and Prusa's mSLA
// profiles use 2 to 5 mm).
inline constexpr Nanometers kBackOff{5'000'000};
// Distance past the full travel after which homing gives up on a switch that has not triggered.
inline constexpr Nanometers kOvertravel{5'000'000};
// Longest move by hand, made to see which way the plate goes: far enough to be seen, less than homing backs
// off. With microsteps misconfigured by a factor of 16 the plate moves 32 mm, so it belongs in the middle of
// its travel.
inline constexpr Nanometers kLongestNudge{2'000'000};
// Speed of a move by hand: slow enough to leave time to pull the plug.
inline constexpr MillimetersPerSecond kNudgeSpeed{1};

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

  // Rises along the plan without a stop. Returns at once; `done` is called from the event loop, also when
  // nothing moved: the plan must start where the plate is, to a microstep, and stay within the travel, within
  // the axis' acceleration, and within the speed from which its motor can stop dead, so that a step that is
  // late costs nothing but time. A rise that is slowed down by a disturbance ends with Stopped. REQUIRES: not
  // moving.
  virtual void rise(const RisePlan& plan, std::function<void(MoveResult)> done) = 0;

  // Moves by `distance`, up or (below 0) down, even if the position is unknown; it is unknown from then on.
  // For an axis whose wiring is yet to be checked, so the move ends where the limit switch closes, even if
  // that is at the wrong end. Returns at once; `done` is called from the event loop. REQUIRES: not moving; no
  // further than kLongestNudge.
  virtual void nudge(Nanometers distance, MillimetersPerSecond speed,
                     std::function<void(MoveResult)> done) = 0;

  // Moves up by `distance` like nudge(), but as far as the travel: lifts a part out of the resin, or peels it
  // off, while the position is unknown. REQUIRES: not moving; 0 <= distance <= travel().
  virtual void raise(Nanometers distance, MillimetersPerSecond speed,
                     std::function<void(MoveResult)> done) = 0;

  // Makes the position known without homing: the caller knows that the plate rests at this height, after a
  // motion upwards. REQUIRES: not moving.
  virtual void assume_height(Nanometers height) = 0;
  // True if the limit switch is at the top: homing moves the plate up, away from film and resin.
  [[nodiscard]] virtual bool homes_upwards() const = 0;

  // Sets the height at which the plate, or the part on it, meets the film, for moves from now on; 0 at first
  // and from homing on. With a force line, a move down that meets resistance further above ends with
  // MoveResult::Resistance.
  virtual void expect_contact_at(Nanometers /*height*/) {}
  // True while the force line is active; nullopt if there is none.
  [[nodiscard]] virtual std::optional<bool> force() const { return std::nullopt; }
  // Runs `call` from the event loop for every change of the force from now on; replaces the call before.
  virtual void on_force(std::function<void(const ForceChange&)> call) {
    [[maybe_unused]] const auto dropped = std::move(call);
  }

  // Decelerates to a standstill; the move's `done` gets Stopped. Does nothing if the axis does not move.
  virtual void stop() = 0;

  // Makes no further step from this instant, and drops a pending `done`. The position is unknown afterwards
  // if a move was under way.
  virtual void abort() noexcept = 0;

  // Turns the motor's current off: the axis can be turned by hand, the plate may sink, and its position is
  // unknown. The next motion turns the current on again. False, and nothing changed, if there is no line for
  // that. REQUIRES: not moving.
  virtual bool release() = 0;

  [[nodiscard]] virtual bool moving() const = 0;

  // Return the plate's height now, or at a time within the move under way; nullopt while the position is
  // unknown.
  [[nodiscard]] virtual std::optional<Nanometers> height() const = 0;
  [[nodiscard]] virtual std::optional<Nanometers> height_at(TimePoint time) const = 0;

  // Returns how much higher the last homing found the limit switch than the homing before it, by the steps
  // made in between; nullopt if the last homing failed, or the position was unknown before it.
  [[nodiscard]] virtual std::optional<Nanometers> homing_shift() const = 0;

  // Returns the greatest height that move_to() accepts (soft limit); the least is 0.
  [[nodiscard]] virtual Nanometers travel() const = 0;

  // Returns how long a move over `distance` takes, for progress and for motion timeouts.
  [[nodiscard]] virtual Duration move_duration(Nanometers distance, MillimetersPerSecond speed) const = 0;

  // Reads all inputs that are fitted; takes some microseconds each.
  [[nodiscard]] virtual std::vector<AxisInputState> inputs() const = 0;

  // Returns the late steps of all moves since the axis was opened; none if no motor has to be stepped.
  [[nodiscard]] virtual LateSteps late_steps() const = 0;

  // Sets the light that the emergency stop, the lid, the power-fail signal and unreadable inputs turn off
  // without waiting for the event loop; null for none. The cutoff must outlive the axis, or be replaced by
  // null before it is destroyed.
  virtual void set_light_cutoff(LightCutoff* cutoff) noexcept = 0;
};

}  // namespace contourd
