// A serial projector's light as one table: the effects of each event in each state. Only this table decides
// whether light off is sent. ProjectorLight carries out the effects; `contourd --print-states` draws the
// table.
//
// The light counts as on from the first byte of light on, or of power on, until it is confirmed off. Light on
// is never sent again: if its reply is lost, contourd asks the projector, or turns its light off.
#pragma once

#include "hw/state_table.hpp"

namespace contourd {

enum class ProjectorLightState {
  Dark,             // the light is off, as far as is known
  TurningOn,        // light on was sent, its reply is pending
  AskedWhetherLit,  // light on's reply was lost or ambiguous, so the projector was asked
  Lit,              // the light is on, as far as is known
  ComingUp,         // power on was sent: the projector comes up with a picture of its own
  MakingSure,       // light off is sent although there is no sign of light
  TurningOff,       // light off is sent until it is confirmed
  Overdue,          // TurningOff, after the missing confirmation was reported
  // Light off was not confirmed, as usual for a projector that is off, so the projector was asked whether it
  // is on at all.
  AskedWhetherOn,
  LitAskedWhetherOn,      // AskedWhetherOn, where there may be light
  OverdueAskedWhetherOn,  // LitAskedWhetherOn, after the missing confirmation was reported
  LostLit,                // the line was lost before light off was confirmed
  LostOverdue,            // LostLit, after the missing confirmation was reported
};

enum class ProjectorLightEvent {
  LightOnSent,  // the first byte was sent
  LightOnConfirmed,
  LightOnAmbiguous,   // the reply may be another command's, and the table has no query for the light
  LightOnUnanswered,  // no reply or an ambiguous one, but the table has a query for the light
  LightOnFailed,      // refused, never sent, or no reply and no query for the light
  SaysLit,
  SaysUnlit,  // or the projector gave no answer
  PowerOnSent,
  Suspected,  // the projector has come up or its warm-up is over: its light may be on
  LightOffWanted,
  LightOffConfirmed,
  LightOffTooEarly,    // not confirmed, but the projector is warming up
  LightOffUnanswered,  // no reply, but the table has a query for the power
  LightOffRefused,     // refused, but the table has a query for the power
  LightOffFailed,      // not confirmed, and no query for the power
  LightOffGarbled,     // LightOffUnanswered or LightOffFailed, after bytes that made no sense
  LightOffUnclear,     // LightOffRefused, after more bytes that made no sense
  LineLost,
  RetryDue,
  SaysOff,
  SaysOn,  // or the projector sent bytes that make no sense
  SaysNothing,
  SaysTooEarly,  // any answer or none, while the projector is warming up
  PowerIsOff,
};

enum class ProjectorLightEffect {
  SendLightOff,    // at once, ahead of all other commands; only replies to this light off count
  RepeatLightOff,  // at once, ahead of all other commands; replies to the previous light off count too
  RetryLater,      // sends light off after a pause
  StopSending,     // drops a pending light off
  AskWhetherLit,
  AskWhetherOn,
  NoteLightOn,      // the light's time starts, and turn_on() is answered with `sent`
  NoteLit,          // the light was on by now
  NoteDark,         // the light was off by now
  DropLightOn,      // drops a pending light on, which must not follow a light off that failed
  TellLit,          // answers turn_on(): the light is on
  TellUnlit,        // answers turn_on(): the light is not on
  TellDark,         // answers when_dark()
  TellConfirmed,    // answers tell_whether_dark()
  TellUnconfirmed,  // answers tell_whether_dark()
  ReportOverdue,
  ReportDark,  // after ReportOverdue
};

template <>
inline constexpr auto kNames<ProjectorLightState> = names_to<ProjectorLightState::LostOverdue>(
    "dark, turning on, asked whether lit, lit, coming up, making sure, turning off, overdue, "
    "asked whether on, lit asked whether on, overdue asked whether on, lost lit, lost overdue");
template <>
inline constexpr auto kNames<ProjectorLightEvent> = names_to<ProjectorLightEvent::PowerIsOff>(
    "light on sent, light on confirmed, light on ambiguous, light on unanswered, light on failed, says lit, "
    "says unlit, power on sent, suspected, light off wanted, light off confirmed, light off too early, "
    "light off unanswered, light off refused, light off failed, light off garbled, light off unclear, "
    "line lost, retry due, says off, says on, says nothing, says too early, power is off");
template <>
inline constexpr auto kNames<ProjectorLightEffect> = names_to<ProjectorLightEffect::ReportDark>(
    "send light off, repeat light off, retry later, stop sending, ask whether lit, ask whether on, "
    "note light on, note lit, note dark, drop light on, tell lit, tell unlit, tell dark, tell confirmed, "
    "tell unconfirmed, report overdue, report dark");

using ProjectorLightTransition =
    StateTransition<ProjectorLightState, ProjectorLightEvent, ProjectorLightEffect>;

[[nodiscard]] const StateTable<ProjectorLightTransition>& projector_light_table();

// True if the light may be on.
[[nodiscard]] bool may_shine(ProjectorLightState state);
// True if light off is to be sent until it is confirmed.
[[nodiscard]] bool is_turned_off(ProjectorLightState state);
// True if a missing confirmation of light off was reported, and light off has not been confirmed since.
[[nodiscard]] bool is_overdue(ProjectorLightState state);

}  // namespace contourd
