// The printer controlled by hand, as one table: in which state which event leads where, and what is done on
// the way. Only while nothing prints. `contourd --print-states` draws it.
#pragma once

#include <span>
#include <string_view>

#include "hw/state_table.hpp"

namespace contourd {

enum class ManualState {
  Idle,
  Homing,
  Moving,
  Braking,        // a stopped motion, to a standstill
  PoweringOn,     // the projector, until it is warm
  WarmingUp,      // the same before the light
  Igniting,       // light on, until its command is sent
  Lit,            // for as long as was asked
  Extinguishing,  // until the light is confirmed off
  Asking,         // the projector's status
};

enum class ManualEvent {
  Home,
  Move,
  Nudge,  // a short way from nobody knows where
  PowerOn,
  PowerOff,
  LightOn,
  AskStatus,
  Homed,
  MoveEnded,
  ProjectorReady,
  LightOnSent,  // from here on there may be light
  TimeOver,     // the light's
  LightIsOff,   // confirmed
  StatusTold,
  Stop,    // who asked for it has said so, or is gone
  Failed,  // a device failed, did not answer in time, or reported an event
  GaveUp,  // nobody has confirmed in time that the light is off
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

// All rows.
[[nodiscard]] std::span<const ManualTransition> manual_transitions();

[[nodiscard]] std::string_view name_of(ManualState state);
[[nodiscard]] std::string_view name_of(ManualEvent event);
[[nodiscard]] std::string_view name_of(ManualEffect effect);

}  // namespace contourd
