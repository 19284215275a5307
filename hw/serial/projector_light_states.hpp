// A serial projector's light as one table: what each event does in each state. Nothing else decides whether
// light off is sent. `contourd --print-states` draws it.
//
// The light is taken as on from the first byte of light on, or of power on, until it is confirmed off. Light
// on is never sent again: where its reply is lost the projector is asked, or its light is turned off.
#pragma once

#include <span>
#include <string_view>

#include "hw/state_table.hpp"

namespace contourd {

enum class ProjectorLightState {
  Dark,             // as far as anybody can tell
  TurningOn,        // light on is sent, its reply is waited for
  AskedWhetherLit,  // that was lost, or may be another command's
  Lit,              // as far as anybody can tell
  ComingUp,         // power on is sent: it comes up with a picture of its own
  MakingSure,       // light off is sent though nothing says that there is light
  TurningOff,       // light off is sent until it is confirmed
  Overdue,          // the same, and that it is not confirmed was reported
  // Light off was not confirmed, as by many that are off: it is asked whether it is on at all.
  AskedWhetherOn,
  LitAskedWhetherOn,      // the same where there may be light
  OverdueAskedWhetherOn,  // the same where that was reported
  LostLit,                // the line was lost before light off was confirmed
  LostOverdue,            // the same where that was reported
};

enum class ProjectorLightEvent {
  LightOnSent,  // its first byte
  LightOnConfirmed,
  LightOnAmbiguous,   // a reply that may be another command's; it cannot be asked whether it is lit
  LightOnUnanswered,  // no reply, or such a one; it can be asked
  LightOnFailed,      // refused, never sent, or no reply and it cannot be asked
  SaysLit,
  SaysUnlit,  // or nothing
  PowerOnSent,
  Suspected,  // it has come up or its warm-up is over: its light may be on
  LightOffWanted,
  LightOffConfirmed,
  LightOffTooEarly,    // not confirmed, but it warms up
  LightOffUnanswered,  // no reply; it can be asked whether it is on
  LightOffRefused,     // it can be asked whether it is on
  LightOffFailed,      // neither confirmed, nor can it be asked
  LightOffGarbled,     // the same, or no reply, and what came made no sense
  LightOffUnclear,     // refused, but more came and made no sense; it can be asked
  LineLost,
  RetryDue,
  SaysOff,
  SaysOn,  // or what makes no sense
  SaysNothing,
  SaysTooEarly,  // anything, but it warms up
  PowerIsOff,
};

enum class ProjectorLightEffect {
  SendLightOff,    // now, ahead of all others; only replies to this one count
  RepeatLightOff,  // now, ahead of all others; replies to the one before count too
  RetryLater,      // light off, after a pause
  StopSending,     // light off, which waits
  AskWhetherLit,
  AskWhetherOn,
  NoteLightOn,  // the light counts from here, and who asked for it is told
  NoteLit,      // it was on by now
  NoteDark,     // it was off by now
  DropLightOn,  // that waits: none behind a light off that failed
  TellLit,      // who asked for the light
  TellUnlit,
  TellDark,         // who waits for darkness
  TellConfirmed,    // who waits for the answer to light off
  TellUnconfirmed,  // the same
  ReportOverdue,
  ReportDark,  // behind that
};

using ProjectorLightTransition =
    StateTransition<ProjectorLightState, ProjectorLightEvent, ProjectorLightEffect>;

// All rows. An event without a row in a state means nothing there: it comes too late.
[[nodiscard]] std::span<const ProjectorLightTransition> projector_light_transitions();

// The light may be on.
[[nodiscard]] bool may_shine(ProjectorLightState state);
// Light off is to be sent until it is confirmed.
[[nodiscard]] bool is_turned_off(ProjectorLightState state);
// That light off is not confirmed was reported, and nothing better since.
[[nodiscard]] bool is_overdue(ProjectorLightState state);

[[nodiscard]] std::string_view name_of(ProjectorLightState state);
[[nodiscard]] std::string_view name_of(ProjectorLightEvent event);
[[nodiscard]] std::string_view name_of(ProjectorLightEffect effect);

}  // namespace contourd
