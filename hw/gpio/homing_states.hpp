// Homing as one table of transitions. Only this table decides the motor's motion before the plate's position
// is known. `contourd --print-states` draws it.
//
// Homing moves towards the limit switch at homing speed; 5 mm back; towards it again at half the speed, which
// finds the position; then to the switch's height.
#pragma once

#include "hw/state_table.hpp"

namespace contourd {

enum class HomingState {
  Idle,
  GettingReady,  // until the motor may turn
  FastPass,      // towards the switch, until its contact has settled
  FastPassOver,  // all steps made; the switch may have closed with the last one
  BackingOff,
  BackedOff,  // until the switch has settled
  SlowPass,
  SlowPassOver,
  AtSwitch,      // until the plate rests
  Approaching,   // to the switch's height
  PassStopping,  // after a stop request in a pass; the switch's contact is ignored
  Stopping,      // after a stop request in any other state
};

enum class HomingEvent {
  HomeWanted,
  SwitchOpen,    // the result of LookAtSwitch
  SwitchClosed,  // the result of LookAtSwitch
  Contact,       // the switch closed in the pass and stayed closed
  Spike,         // the switch closed in the pass but did not stay closed
  WayOver,       // the run has made all its steps
  WaitOver,
  Arrived,
  StopWanted,
  Stopped,
  Failed,  // a fault, which has been reported already
  Aborted,
};

enum class HomingEffect {
  ForgetPosition,
  GetReady,
  SeekFast,
  SeekSlow,
  SeekOn,  // makes the remaining steps of the pass
  BackOff,
  AwaitContact,
  LookAtSwitch,  // after it has had time to settle
  TakePosition,  // from the time at which the switch closed
  AwaitRest,     // only needed with an encoder
  KnowPosition,
  Approach,
  StopMotor,
  TellHomed,
  TellNoTrigger,
  TellStillClosed,
  TellStopped,
  TellFailed,
  DropAnswer,
};

template <>
inline constexpr auto kNames<HomingState> = names_to<HomingState::Stopping>(
    "idle, getting ready, fast pass, fast pass over, backing off, backed off, slow pass, slow pass over, "
    "at switch, approaching, pass stopping, stopping");
template <>
inline constexpr auto kNames<HomingEvent> = names_to<HomingEvent::Aborted>(
    "home wanted, switch open, switch closed, contact, spike, way over, wait over, arrived, stop wanted, "
    "stopped, failed, aborted");
template <>
inline constexpr auto kNames<HomingEffect> = names_to<HomingEffect::DropAnswer>(
    "forget position, get ready, seek fast, seek slow, seek on, back off, await contact, look at switch, "
    "take position, await rest, know position, approach, stop motor, tell homed, tell no trigger, "
    "tell still closed, tell stopped, tell failed, drop answer");

using HomingTransition = StateTransition<HomingState, HomingEvent, HomingEffect>;

[[nodiscard]] const StateTable<HomingTransition>& homing_table();

// True for the states in which a contact of the switch halts the motor.
[[nodiscard]] bool is_in_pass(HomingState state);

}  // namespace contourd
