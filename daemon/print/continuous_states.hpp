// A print whose plate rises without a stop, as one table of transitions: for a state and an event, the next
// state and the effects on the way. The layers beneath, between and above its rises are layered prints of
// their own.
#pragma once

#include <span>

#include "daemon/print/print_mode.hpp"
#include "hw/state_table.hpp"

namespace contourd {

enum class ContinuousState {
  Idle,
  Layering,    // layers are printed one by one: the first ones, those between two rises, or all
  Recovering,  // in the dark, until the window has its oxygen again
  Lowering,    // the plate moves to the height from which it rises
  Settling,    // the resin settles
  Showing,     // until the kernel reports that the first mask is on the screen
  Igniting,    // until the light-on command is sent
  Rising,      // the plate rises in the light, and each refresh shows the mask for its height
  Slowing,     // in the light, until the plate stands, from where it rises at other speeds
  Braking,     // light off is sent; until the plate has come to a standstill
  Darkening,   // until the light is confirmed off
  Lifting,     // the plate moves up, out of the resin
  Paused,
  Parking,  // the plate moves up to its parking height
  Ending,   // until the light is confirmed off; everything else is done
};

enum class ContinuousEvent {
  Started,
  LayeringEnded,  // the layered print has ended, and no rise follows
  MoveEnded,
  WaitOver,
  MaskShown,
  LightOnSent,    // there may be light from now on
  RiseBroken,     // a disturbance has stopped the plate
  TooFast,        // a mask was missed, and the rise is to be slower
  SpeedsChanged,  // by the user
  SlowedDown,     // the plate is at a standstill in the light, and the rise has a rest
  LightIsOff,     // confirmed
  // The plate is up in the dark, and next comes:
  RiseDue,    // a rise, or the rest of one
  RestDue,    // the rest before a rise
  LayersDue,  // layers on top of a rise
  PauseDue,
  RisesOver,    // the plate's way to its parking height: nothing is on top of the last rise
  Interrupted,  // by the user's pause, the lid, the display, a missed mask: turn dark, move up, wait
  Canceled,
  Failed,  // a device failed, did not answer in time, or an effect threw
  GaveUp,  // the light was not confirmed off in time
};

enum class ContinuousEffect {
  PrintLayers,
  PrintMoreLayers,
  InterruptLayers,
  CancelLayers,
  FailLayers,
  LightOff,
  BlackNow,
  AbortAxis,
  StopAxis,
  PowerOff,
  AwaitOxygen,
  LowerToRise,
  WaitToSettle,
  ShowMask,
  LightOn,
  Rise,
  RiseOn,
  AwaitDark,
  Lift,
  Park,
  Finish,
};

template <>
inline constexpr auto kNames<ContinuousState> = names_to<ContinuousState::Ending>(
    "idle, layering, recovering, lowering, settling, showing, igniting, rising, slowing, braking, darkening, "
    "lifting, "
    "paused, "
    "parking, ending");
template <>
inline constexpr auto kNames<ContinuousEvent> = names_to<ContinuousEvent::GaveUp>(
    "started, layering ended, move ended, wait over, mask shown, light on sent, rise broken, too fast, "
    "speeds changed, slowed down, "
    "light is off, rise due, rest due, layers due, pause due, rises over, interrupted, cancelled, failed, "
    "gave up");
template <>
inline constexpr auto kNames<ContinuousEffect> = names_to<ContinuousEffect::Finish>(
    "print layers, print more layers, interrupt layers, cancel layers, fail layers, light off, black now, "
    "abort axis, stop axis, power off, await oxygen, lower to rise, wait to settle, show mask, light on, "
    "rise, rise on, await dark, lift, park, finish");

using ContinuousTransition = StateTransition<ContinuousState, ContinuousEvent, ContinuousEffect>;

[[nodiscard]] const StateTable<ContinuousTransition>& continuous_table();

// Returns the states as other modules see them, in the enumeration's order. A state that has the name of a
// layered print's state is that one; Layering is never seen, but the layered print's own states.
[[nodiscard]] std::span<const PrintState> continuous_print_states();

}  // namespace contourd
