// Manual control of the printer as one table of transitions: for a state and an event, the next state and the
// effects on the way. Used only while nothing prints. `contourd --print-states` draws it.
#pragma once

#include "hw/state_table.hpp"

namespace contourd {

enum class ManualState {
  Idle,
  Homing,
  Moving,
  Braking,        // until a stopped motion has come to a standstill
  PoweringOn,     // until the projector is on and warm
  WarmingUp,      // until the projector is on and warm; light follows
  Igniting,       // until the light-on command is sent
  Lit,            // until the requested time is over
  Extinguishing,  // until the light is confirmed off
  Asking,         // until the projector's status has arrived
};

enum class ManualEvent {
  Home,
  Move,
  Nudge,  // a short move from an unknown position
  PowerOn,
  PowerOff,
  LightOn,
  AskStatus,
  Homed,
  MoveEnded,
  ProjectorReady,
  LightOnSent,  // there may be light from now on
  TimeOver,     // the requested time of light
  LightIsOff,   // confirmed
  StatusTold,
  Stop,    // requested, or the client that began the operation has disconnected
  Failed,  // a device failed, did not answer in time, or reported an event
  GaveUp,  // the light was not confirmed off in time
};

enum class ManualEffect {
  LightOff,
  BlackNow,
  AbortAxis,
  StopAxis,
  Home,
  Move,
  Nudge,
  PowerOn,
  PowerOff,
  LightOn,
  TimeLight,
  AwaitDark,
  AskStatus,
  TellLightMayBeOn,
};

template <>
inline constexpr auto kNames<ManualState> = names_to<ManualState::Asking>(
    "idle, homing, moving, braking, powering on, warming up, igniting, lit, extinguishing, asking");
template <>
inline constexpr auto kNames<ManualEvent> = names_to<ManualEvent::GaveUp>(
    "home, move, nudge, power on, power off, light on, ask status, homed, move ended, projector ready, "
    "light on sent, time over, light is off, status told, stop, failed, gave up");
template <>
inline constexpr auto kNames<ManualEffect> = names_to<ManualEffect::TellLightMayBeOn>(
    "light off, black now, abort axis, stop axis, home, move, nudge, power on, power off, light on, "
    "time light, await dark, ask status, tell that the light may be on");

using ManualTransition = StateTransition<ManualState, ManualEvent, ManualEffect>;

[[nodiscard]] const StateTable<ManualTransition>& manual_table();

}  // namespace contourd
