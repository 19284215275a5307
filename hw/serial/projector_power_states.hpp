// A serial projector's power as one table: what each event does in each state. Nothing else decides whether
// it is turned on or off. `contourd --print-states` draws it.
//
// What turns it on is dropped by light off; what turns it off goes on until that is confirmed, or power on is
// wanted.
#pragma once

#include <span>
#include <string_view>

#include "hw/state_table.hpp"

namespace contourd {

enum class ProjectorPowerState {
  Unknown,
  LeftOn,  // a process that has died may have left it on: asked until it answers, then turned off
  Off,
  // Power on is wanted: it is asked whether it is on already,
  Asking,
  OffAsking,        // the same where it was off,
  OnAsking,         // and where it was on,
  CoolingDown,      // until it can be turned on again,
  OffCoolingDown,   // the same where it is known to be off,
  SwitchingOn,      // until power on is answered,
  WarmingUp,        // until it is warm,
  AskingReady,      // warm: whether it is on by now,
  StillOff,         // before another power on,
  Unready,          // before it is asked again,
  OnWarmingUp,      // it says that it is on, but may warm up,
  Darkening,        // on and warm: until its light is confirmed off,
  SetsBrightness,   // until that is answered.
  On,               // warm, and as far as anybody knows
  WarmingUpUnused,  // power on was answered, then dropped
  TurningOff,       // power off is sent until it is confirmed
  OffOverdue,       // the same, and that it is not confirmed was reported
};

enum class ProjectorPowerEvent {
  PowerOnWanted,
  Dropped,  // by light off
  PowerOffWanted,
  LeftOnSuspected,
  SaysOn,
  SaysOnEarly,  // the same, but it may warm up
  SaysOff,
  SaysUnclear,  // neither
  SaysNothing,
  NeverOn,   // off or unclear, long after it was turned on
  NotOnYet,  // off, unclear or nothing, but it may warm up
  LineLost,
  Cool,
  Warm,
  PauseOver,
  PowerOnAnswered,
  PowerOnFailed,  // refused, or not answered
  LightIsOff,
  LightOffFailed,  // refused, or not answered
  BrightnessAnswered,
  WentOff,  // by itself, or it fell silent
  PowerOffConfirmed,
  PowerOffUnanswered,  // or refused
  PowerOffLate,        // the same, long after it was sent first
  PowerOffUnknowable,  // it neither answers nor can be asked, or its line is lost
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
  DropPowerOn,  // that waits
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
  NoteOff,  // it needs no warm-up any more, and has no light
  Tell,     // who wants it on
  TellNeverOn,
  TellWentOff,
  ReportWentOff,
  ReportLampOn,
};

using ProjectorPowerTransition =
    StateTransition<ProjectorPowerState, ProjectorPowerEvent, ProjectorPowerEffect>;

// All rows. An event without a row in a state means nothing there: it comes too late. Where a row leads to
// another state, what the first one waited for is not waited for any more.
[[nodiscard]] std::span<const ProjectorPowerTransition> projector_power_transitions();

// As far as anybody knows.
[[nodiscard]] bool is_on(ProjectorPowerState state);
[[nodiscard]] bool is_off(ProjectorPowerState state);
// Power off is to be sent until it is confirmed.
[[nodiscard]] bool is_turned_off(ProjectorPowerState state);

[[nodiscard]] std::string_view name_of(ProjectorPowerState state);
[[nodiscard]] std::string_view name_of(ProjectorPowerEvent event);
[[nodiscard]] std::string_view name_of(ProjectorPowerEffect effect);

}  // namespace contourd
