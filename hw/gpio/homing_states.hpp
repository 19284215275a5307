// Homing as one table: what each event does in each state. Nothing else decides where the motor goes before
// the plate's position is known. `contourd --print-states` draws it.
//
// Towards the limit switch at homing speed; 5 mm back; towards it again at half the speed, which finds the
// position; to the switch's height.
#pragma once

#include <span>
#include <string_view>

#include "hw/state_table.hpp"

namespace contourd {

enum class HomingState {
  Idle,
  GettingReady,  // until the motor may turn
  FastPass,      // towards the switch, until its contact has settled
  FastPassOver,  // the whole way, unless the switch closed with the last step
  BackingOff,
  BackedOff,  // until the switch has settled
  SlowPass,
  SlowPassOver,
  AtSwitch,      // until the plate rests
  Approaching,   // to the switch's height
  PassStopping,  // stop was asked for in a pass: what the switch's contact comes to is no matter
  Stopping,      // in any other state
};

enum class HomingEvent {
  HomeWanted,
  SwitchOpen,    // found so,
  SwitchClosed,  // when it was looked at
  Contact,       // it closed in the pass, and stayed closed
  Spike,         // it did not
  WayOver,       // the run's
  WaitOver,
  Arrived,
  StopWanted,
  Stopped,
  Failed,  // a fault, told by its finder
  Aborted,
};

enum class HomingEffect {
  ForgetPosition,
  GetReady,
  SeekFast,
  SeekSlow,
  SeekOn,  // what is left of the pass
  BackOff,
  AwaitContact,
  LookAtSwitch,  // when it has settled
  TakePosition,  // from the time at which the switch closed
  AwaitRest,     // as far as an encoder has to see it
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

using HomingTransition = StateTransition<HomingState, HomingEvent, HomingEffect>;

// All rows. An event without a row in a state means nothing there: it comes too late.
[[nodiscard]] std::span<const HomingTransition> homing_transitions();

// A contact of the switch is what the motor was halted for.
[[nodiscard]] bool is_in_pass(HomingState state);

[[nodiscard]] std::string_view name_of(HomingState state);
[[nodiscard]] std::string_view name_of(HomingEvent event);
[[nodiscard]] std::string_view name_of(HomingEffect effect);

}  // namespace contourd
