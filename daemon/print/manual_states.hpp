// Manual control of the printer as one table of transitions: for a state and an event, the next state and the
// effects on the way. Used only while nothing prints. `contourd --print-states` draws it.
#pragma once

#include <string_view>

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

using ManualTransition = StateTransition<ManualState, ManualEvent, ManualEffect>;

[[nodiscard]] const StateTable<ManualTransition>& manual_table();

[[nodiscard]] std::string_view name_of(ManualState state);
[[nodiscard]] std::string_view name_of(ManualEvent event);
[[nodiscard]] std::string_view name_of(ManualEffect effect);

}  // namespace contourd
