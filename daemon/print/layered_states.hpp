// A print layer by layer as one table of transitions: for a state and an event, the next state and the
// effects on the way. Nothing else decides what happens next. `contourd --print-states` draws it.
#pragma once

#include <optional>
#include <span>

#include "daemon/print/print_mode.hpp"
#include "hw/state_table.hpp"

namespace contourd {

enum class LayeredState {
  Idle,
  WarmingUp,  // until the lamp is warm
  Homing,
  Lowering,  // the plate moves to the layer's height
  Settling,  // the resin settles
  Showing,   // until the kernel reports that the mask is on the screen
  Igniting,  // until the light-on command is sent
  Exposing,
  Darkening,      // light off is sent; until black is on the screen
  Extinguishing,  // until the light is confirmed off
  Interrupting,   // until the light of an interrupted or cancelled exposure is confirmed off
  Resting,        // the wait before the peel
  Lifting,        // peel and lift
  AwaitingDark,   // until the light is confirmed off, before anything moves down into the resin
  Raising,        // the plate moves up so that the user can look at the part
  Paused,
  Held,     // interrupted before the first layer, when the plate's position may be unknown
  Braking,  // until the move of an interrupted print has come to a standstill
  Halting,  // until the move of a cancelled print has come to a standstill
  Parking,  // the plate moves up to its parking height
  Ending,   // until the light is confirmed off; everything else is done
};

enum class LayeredEvent {
  Started,
  WentOn,  // on top of a rise: the projector is on, the plate up at a known height
  ProjectorReady,
  Homed,
  MoveEnded,
  WaitOver,
  MaskShown,
  LightOnSent,  // there may be light from now on
  PictureDue,   // the next picture of a split exposure
  ScreenBlack,
  LightIsOff,       // confirmed
  LayerDue,         // dark, and another layer follows
  LayerUnfinished,  // dark, and the layer still lacks light
  PauseDue,         // dark, and the user requested a pause or something interrupted the print
  LayersDone,       // dark after the last layer
  RiseDue,          // dark after the last layer before a rise
  Interrupted,      // the lid was opened or the display lost: turn dark, move up, wait for the user
  Resumed,
  Canceled,
  Failed,  // a device failed, did not answer in time, or an effect threw
  GaveUp,  // the light was not confirmed off in time
};

enum class LayeredEffect {
  LightOff,
  BlackNow,
  AbortAxis,
  StopAxis,
  PowerOn,
  PowerOff,
  Home,
  LowerToLayer,
  WaitToSettle,
  ShowMask,
  LightOn,
  TimeExposure,
  ShowPicture,
  ShowBlack,
  AwaitDark,
  RecordLayer,  // unless done already: the rest of an interrupted exposure may be too short to be given
  WaitToRest,
  Lift,
  NextLayer,
  RaiseForALook,
  Park,
  Finish,
};

template <>
inline constexpr auto kNames<LayeredState> = names_to<LayeredState::Ending>(
    "idle, warming up, homing, lowering, settling, showing, igniting, exposing, darkening, extinguishing, "
    "interrupting, resting, lifting, awaiting dark, raising, paused, held, braking, halting, parking, "
    "ending");
template <>
inline constexpr auto kNames<LayeredEvent> = names_to<LayeredEvent::GaveUp>(
    "started, went on, projector ready, homed, move ended, wait over, mask shown, light on sent, "
    "picture due, screen black, light is off, layer due, layer unfinished, pause due, layers done, rise due, "
    "interrupted, resumed, cancelled, "
    "failed, gave up");
template <>
inline constexpr auto kNames<LayeredEffect> = names_to<LayeredEffect::Finish>(
    "light off, black now, abort axis, stop axis, power on, power off, home, lower to layer, "
    "wait to settle, show mask, light on, time exposure, show picture, show black, await dark, record layer, "
    "wait to rest, lift, next layer, raise for a look, park, finish");

using LayeredTransition = StateTransition<LayeredState, LayeredEvent, LayeredEffect>;

[[nodiscard]] const StateTable<LayeredTransition>& layered_table();

// Returns the phase of a print that begins with this state; nullopt if the state belongs to the phase before.
[[nodiscard]] std::optional<PrintPhase> phase_of(LayeredState state);

// Returns the states as other modules see them, in the enumeration's order.
[[nodiscard]] std::span<const PrintState> layered_print_states();

}  // namespace contourd
