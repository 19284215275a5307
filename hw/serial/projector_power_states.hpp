// A serial projector's power as one table: the effects of each event in each state. Only this table decides
// whether the projector is turned on or off. `contourd --print-states` draws it.
//
// Light off drops a power on that is under way. A power off goes on until it is confirmed, or power on is
// wanted.
#pragma once

#include "hw/state_table.hpp"

namespace contourd {

enum class ProjectorPowerState {
  Unknown,
  LeftOn,  // a crashed process may have left it on: asked until it answers, then turned off
  Off,
  // Power on is wanted in the states from here to SetsBrightness.
  Asking,           // asked whether it is on already
  OffAsking,        // Asking, while it was off
  OnAsking,         // Asking, while it was on
  CoolingDown,      // until it can be turned on again
  OffCoolingDown,   // CoolingDown, while it is known to be off
  SwitchingOn,      // until power on is answered
  WarmingUp,        // until it is warm
  AskingReady,      // warm: asked whether it is on by now
  StillOff,         // pause before another power on
  Unready,          // pause before it is asked again
  OnWarmingUp,      // says that it is on, but may be warming up
  Darkening,        // on and warm: until its light is confirmed off
  SetsBrightness,   // until the brightness is answered
  On,               // warm, and on as far as is known
  WarmingUpUnused,  // power on was answered, then dropped
  TurningOff,       // power off is sent until it is confirmed
  OffOverdue,       // TurningOff, after the missing confirmation was reported
};

enum class ProjectorPowerEvent {
  PowerOnWanted,
  Dropped,  // by light off
  PowerOffWanted,
  LeftOnSuspected,
  SaysOn,
  SaysOnEarly,  // says that it is on, but may be warming up
  SaysOff,
  SaysUnclear,  // neither on nor off
  SaysNothing,
  NeverOn,   // off or unclear, long after it was turned on
  NotOnYet,  // off, unclear or no answer, but it may be warming up
  LineLost,
  Cool,
  Warm,
  PauseOver,
  PowerOnAnswered,
  PowerOnFailed,  // refused, or not answered
  LightIsOff,
  LightOffFailed,  // refused, or not answered
  BrightnessAnswered,
  WentOff,  // by itself, or fell silent
  PowerOffConfirmed,
  PowerOffUnanswered,  // or refused
  PowerOffLate,        // PowerOffUnanswered, long after it was first requested
  PowerOffUnknowable,  // the projector neither answers nor can be asked, or its line is lost
};

enum class ProjectorPowerEffect {
  LightOff,
  AskWhetherOn,
  AskWhetherStillOn,
  AskWhetherReady,
  AskWhetherLeftOn,
  AskLeftOnSoon,
  AskLeftOnLater,
  WaitUntilCool,
  SendPowerOn,
  DropPowerOn,  // drops a pending power on
  SuspectLight,
  WaitUntilWarm,
  Pause,
  WatchOver,  // ask now and then whether it is still on
  MakeDark,
  SetBrightness,
  SendPowerOff,
  AskWhetherOff,
  PowerOffAgain,
  PowerOffAgainLater,
  NoteOff,  // no warm-up is under way any more, and there is no light
  Tell,     // answers turn_on()
  TellNeverOn,
  TellWentOff,
  ReportWentOff,
  ReportLampOn,
};

template <>
inline constexpr auto kNames<ProjectorPowerState> = names_to<ProjectorPowerState::OffOverdue>(
    "unknown, left on, off, asking, off asking, on asking, cooling down, off cooling down, switching on, "
    "warming up, asking ready, still off, unready, on warming up, darkening, sets brightness, on, "
    "warming up unused, turning off, off overdue");
template <>
inline constexpr auto kNames<ProjectorPowerEvent> = names_to<ProjectorPowerEvent::PowerOffUnknowable>(
    "power on wanted, dropped, power off wanted, left on suspected, says on, says on early, says off, "
    "says unclear, says nothing, never on, not on yet, line lost, cool, warm, pause over, "
    "power on answered, power on failed, light is off, light off failed, brightness answered, went off, "
    "power off confirmed, power off unanswered, power off late, power off unknowable");
template <>
inline constexpr auto kNames<ProjectorPowerEffect> = names_to<ProjectorPowerEffect::ReportLampOn>(
    "light off, ask whether on, ask whether still on, ask whether ready, ask whether left on, "
    "ask left on soon, ask left on later, wait until cool, send power on, drop power on, suspect light, "
    "wait until warm, pause, watch over, make dark, set brightness, send power off, ask whether off, "
    "power off again, power off again later, note off, tell, tell never on, tell went off, report went off, "
    "report lamp on");

using ProjectorPowerTransition =
    StateTransition<ProjectorPowerState, ProjectorPowerEvent, ProjectorPowerEffect>;

// A row that leads to another state ends the wait of the first one.
[[nodiscard]] const StateTable<ProjectorPowerTransition>& projector_power_table();

// True if the projector is on (off), as far as is known.
[[nodiscard]] bool is_on(ProjectorPowerState state);
[[nodiscard]] bool is_off(ProjectorPowerState state);
// True if power off is to be sent until it is confirmed.
[[nodiscard]] bool is_turned_off(ProjectorPowerState state);

}  // namespace contourd
