#include "hw/serial/projector_light_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ProjectorLightState;
using E = ProjectorLightEvent;
using F = ProjectorLightEffect;

template <typename... Effects>
constexpr ProjectorLightTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= ProjectorLightTransition::kMaxEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

constexpr ProjectorLightTransition confirmed(S from, E on) {
  return row(from, on, S::Dark, F::NoteDark, F::TellDark, F::TellConfirmed);
}
constexpr ProjectorLightTransition confirmed_at_last(S from, E on) {
  return row(from, on, S::Dark, F::NoteDark, F::TellDark, F::ReportDark, F::TellConfirmed);
}

// Light off was sent often enough: this is reported, and light off is tried on and on.
constexpr ProjectorLightTransition overdue(S from, E on) {
  return row(from, on, S::Overdue, F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed);
}
constexpr ProjectorLightTransition still_overdue(S from, E on) {
  return row(from, on, S::Overdue, F::RetryLater, F::DropLightOn, F::TellUnconfirmed);
}

// A projector without power has no light.
constexpr ProjectorLightTransition power_is_off(S from) {
  return row(from, E::PowerIsOff, S::Dark, F::StopSending, F::NoteDark, F::TellDark);
}
constexpr ProjectorLightTransition power_is_off_at_last(S from) {
  return row(from, E::PowerIsOff, S::Dark, F::StopSending, F::NoteDark, F::TellDark, F::ReportDark);
}

constexpr auto kTable = std::to_array<ProjectorLightTransition>({
    // Light on. From its first byte on the light counts as on.
    row(S::Dark, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    row(S::AskedWhetherOn, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    row(S::Lit, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    row(S::ComingUp, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    row(S::LitAskedWhetherOn, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    row(S::LostLit, E::LightOnSent, S::TurningOn, F::NoteLightOn),
    // The light is meant to be off: a light on that slipped out is followed by a light off of its own.
    row(S::MakingSure, E::LightOnSent, S::TurningOff, F::NoteLightOn, F::SendLightOff, F::TellUnlit),
    row(S::TurningOff, E::LightOnSent, S::TurningOff, F::NoteLightOn, F::SendLightOff, F::TellUnlit),
    row(S::Overdue, E::LightOnSent, S::Overdue, F::NoteLightOn, F::SendLightOff, F::TellUnlit),
    row(S::TurningOn, E::LightOnConfirmed, S::Lit, F::NoteLit, F::TellLit),
    row(S::TurningOn, E::LightOnAmbiguous, S::Lit, F::TellLit),
    row(S::TurningOn, E::LightOnUnanswered, S::AskedWhetherLit, F::AskWhetherLit),
    // A light on that is not confirmed may have been obeyed.
    row(S::TurningOn, E::LightOnFailed, S::TurningOff, F::SendLightOff, F::TellUnlit),
    row(S::AskedWhetherLit, E::SaysLit, S::Lit, F::NoteLit, F::TellLit),
    row(S::AskedWhetherLit, E::SaysUnlit, S::TurningOff, F::SendLightOff, F::TellUnlit),
    // Light on was never sent.
    row(S::Dark, E::LightOnFailed, S::MakingSure, F::SendLightOff, F::TellUnlit),
    row(S::AskedWhetherOn, E::LightOnFailed, S::MakingSure, F::SendLightOff, F::TellUnlit),

    // Power on may be obeyed without an answer.
    row(S::Dark, E::PowerOnSent, S::ComingUp),
    row(S::AskedWhetherOn, E::PowerOnSent, S::LitAskedWhetherOn),
    // Replies to a light off that was sent before power on do not count any more.
    row(S::MakingSure, E::PowerOnSent, S::TurningOff, F::SendLightOff),
    row(S::TurningOff, E::PowerOnSent, S::TurningOff, F::SendLightOff),
    row(S::Overdue, E::PowerOnSent, S::Overdue, F::SendLightOff),
    row(S::Dark, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::TurningOn, E::Suspected, S::TurningOff, F::SendLightOff, F::TellUnlit),
    row(S::AskedWhetherLit, E::Suspected, S::TurningOff, F::SendLightOff, F::TellUnlit),
    row(S::Lit, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::ComingUp, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::AskedWhetherOn, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::LitAskedWhetherOn, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::LostLit, E::Suspected, S::TurningOff, F::SendLightOff),
    row(S::MakingSure, E::Suspected, S::TurningOff, F::RepeatLightOff),
    row(S::TurningOff, E::Suspected, S::TurningOff, F::RepeatLightOff),
    row(S::Overdue, E::Suspected, S::Overdue, F::RepeatLightOff),
    row(S::OverdueAskedWhetherOn, E::Suspected, S::Overdue, F::SendLightOff),
    row(S::LostOverdue, E::Suspected, S::Overdue, F::SendLightOff),

    // Light off is sent in every state, whatever is known.
    row(S::Dark, E::LightOffWanted, S::MakingSure, F::SendLightOff),
    row(S::AskedWhetherOn, E::LightOffWanted, S::MakingSure, F::SendLightOff),
    row(S::TurningOn, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::AskedWhetherLit, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::Lit, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::ComingUp, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::LitAskedWhetherOn, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::LostLit, E::LightOffWanted, S::TurningOff, F::SendLightOff),
    row(S::OverdueAskedWhetherOn, E::LightOffWanted, S::Overdue, F::SendLightOff),
    row(S::LostOverdue, E::LightOffWanted, S::Overdue, F::SendLightOff),
    row(S::MakingSure, E::LightOffWanted, S::MakingSure, F::RepeatLightOff),
    row(S::TurningOff, E::LightOffWanted, S::TurningOff, F::RepeatLightOff),
    row(S::Overdue, E::LightOffWanted, S::Overdue, F::RepeatLightOff),
    row(S::MakingSure, E::RetryDue, S::MakingSure, F::RepeatLightOff),
    row(S::TurningOff, E::RetryDue, S::TurningOff, F::RepeatLightOff),
    row(S::Overdue, E::RetryDue, S::Overdue, F::RepeatLightOff),

    confirmed(S::MakingSure, E::LightOffConfirmed),
    confirmed(S::TurningOff, E::LightOffConfirmed),
    confirmed_at_last(S::Overdue, E::LightOffConfirmed),
    // The callback of when_dark() goes on waiting.
    row(S::MakingSure, E::LightOffTooEarly, S::MakingSure, F::RetryLater),
    row(S::TurningOff, E::LightOffTooEarly, S::TurningOff, F::RetryLater),
    row(S::Overdue, E::LightOffTooEarly, S::Overdue, F::RetryLater),

    // There is no sign of light: the projector may be off.
    row(S::MakingSure, E::LightOffUnanswered, S::AskedWhetherOn, F::TellDark, F::AskWhetherOn),
    row(S::MakingSure, E::LightOffRefused, S::AskedWhetherOn, F::TellDark, F::AskWhetherOn),
    row(S::MakingSure, E::LightOffFailed, S::Dark, F::TellDark, F::TellUnconfirmed),
    row(S::MakingSure, E::LightOffGarbled, S::TurningOff, F::SendLightOff),
    row(S::MakingSure, E::LightOffUnclear, S::TurningOff, F::SendLightOff),
    row(S::MakingSure, E::LineLost, S::Dark, F::TellUnconfirmed),

    // There may be light: only a confirmation ends this, or the projector's answer that it is off.
    overdue(S::TurningOff, E::LightOffUnanswered),
    overdue(S::TurningOff, E::LightOffFailed),
    overdue(S::TurningOff, E::LightOffGarbled),
    row(S::TurningOff, E::LightOffRefused, S::LitAskedWhetherOn, F::AskWhetherOn),
    row(S::TurningOff, E::LightOffUnclear, S::TurningOff, F::SendLightOff),
    row(S::TurningOff, E::LineLost, S::LostLit, F::TellUnconfirmed),
    still_overdue(S::Overdue, E::LightOffUnanswered),
    still_overdue(S::Overdue, E::LightOffFailed),
    still_overdue(S::Overdue, E::LightOffGarbled),
    row(S::Overdue, E::LightOffRefused, S::OverdueAskedWhetherOn, F::AskWhetherOn),
    row(S::Overdue, E::LightOffUnclear, S::Overdue, F::SendLightOff),
    row(S::Overdue, E::LineLost, S::LostOverdue, F::TellUnconfirmed),

    confirmed(S::AskedWhetherOn, E::SaysOff),
    row(S::AskedWhetherOn, E::SaysOn, S::TurningOff, F::SendLightOff),
    row(S::AskedWhetherOn, E::SaysNothing, S::Dark, F::TellUnconfirmed),
    row(S::AskedWhetherOn, E::SaysTooEarly, S::MakingSure, F::RetryLater),
    confirmed(S::LitAskedWhetherOn, E::SaysOff),
    overdue(S::LitAskedWhetherOn, E::SaysOn),
    overdue(S::LitAskedWhetherOn, E::SaysNothing),
    row(S::LitAskedWhetherOn, E::SaysTooEarly, S::TurningOff, F::RetryLater),
    confirmed_at_last(S::OverdueAskedWhetherOn, E::SaysOff),
    still_overdue(S::OverdueAskedWhetherOn, E::SaysOn),
    still_overdue(S::OverdueAskedWhetherOn, E::SaysNothing),
    row(S::OverdueAskedWhetherOn, E::SaysTooEarly, S::Overdue, F::RetryLater),
    // The answer came after a power off was confirmed.
    row(S::Dark, E::SaysOn, S::TurningOff, F::SendLightOff),

    power_is_off(S::Dark),
    power_is_off(S::TurningOn),
    power_is_off(S::AskedWhetherLit),
    power_is_off(S::Lit),
    power_is_off(S::ComingUp),
    power_is_off(S::MakingSure),
    power_is_off(S::TurningOff),
    power_is_off(S::AskedWhetherOn),
    power_is_off(S::LitAskedWhetherOn),
    power_is_off(S::LostLit),
    power_is_off_at_last(S::Overdue),
    power_is_off_at_last(S::OverdueAskedWhetherOn),
    power_is_off_at_last(S::LostOverdue),
});

}  // namespace

std::span<const ProjectorLightTransition> projector_light_transitions() {
  return kTable;
}

bool may_shine(ProjectorLightState state) {
  return state != S::Dark && state != S::MakingSure && state != S::AskedWhetherOn;
}

bool is_turned_off(ProjectorLightState state) {
  return state == S::MakingSure || state == S::TurningOff || state == S::Overdue;
}

bool is_overdue(ProjectorLightState state) {
  return state == S::Overdue || state == S::OverdueAskedWhetherOn || state == S::LostOverdue;
}

std::string_view name_of(ProjectorLightState state) {
  switch (state) {
    case S::Dark:
      return "dark";
    case S::TurningOn:
      return "turning on";
    case S::AskedWhetherLit:
      return "asked whether lit";
    case S::Lit:
      return "lit";
    case S::ComingUp:
      return "coming up";
    case S::MakingSure:
      return "making sure";
    case S::TurningOff:
      return "turning off";
    case S::Overdue:
      return "overdue";
    case S::AskedWhetherOn:
      return "asked whether on";
    case S::LitAskedWhetherOn:
      return "lit asked whether on";
    case S::OverdueAskedWhetherOn:
      return "overdue asked whether on";
    case S::LostLit:
      return "lost lit";
    case S::LostOverdue:
      return "lost overdue";
  }
  return "?";
}

std::string_view name_of(ProjectorLightEvent event) {
  switch (event) {
    case E::LightOnSent:
      return "light on sent";
    case E::LightOnConfirmed:
      return "light on confirmed";
    case E::LightOnAmbiguous:
      return "light on ambiguous";
    case E::LightOnUnanswered:
      return "light on unanswered";
    case E::LightOnFailed:
      return "light on failed";
    case E::SaysLit:
      return "says lit";
    case E::SaysUnlit:
      return "says unlit";
    case E::PowerOnSent:
      return "power on sent";
    case E::Suspected:
      return "suspected";
    case E::LightOffWanted:
      return "light off wanted";
    case E::LightOffConfirmed:
      return "light off confirmed";
    case E::LightOffTooEarly:
      return "light off too early";
    case E::LightOffUnanswered:
      return "light off unanswered";
    case E::LightOffRefused:
      return "light off refused";
    case E::LightOffFailed:
      return "light off failed";
    case E::LightOffGarbled:
      return "light off garbled";
    case E::LightOffUnclear:
      return "light off unclear";
    case E::LineLost:
      return "line lost";
    case E::RetryDue:
      return "retry due";
    case E::SaysOff:
      return "says off";
    case E::SaysOn:
      return "says on";
    case E::SaysNothing:
      return "says nothing";
    case E::SaysTooEarly:
      return "says too early";
    case E::PowerIsOff:
      return "power is off";
  }
  return "?";
}

std::string_view name_of(ProjectorLightEffect effect) {
  switch (effect) {
    case F::SendLightOff:
      return "send light off";
    case F::RepeatLightOff:
      return "repeat light off";
    case F::RetryLater:
      return "retry later";
    case F::StopSending:
      return "stop sending";
    case F::AskWhetherLit:
      return "ask whether lit";
    case F::AskWhetherOn:
      return "ask whether on";
    case F::NoteLightOn:
      return "note light on";
    case F::NoteLit:
      return "note lit";
    case F::NoteDark:
      return "note dark";
    case F::DropLightOn:
      return "drop light on";
    case F::TellLit:
      return "tell lit";
    case F::TellUnlit:
      return "tell unlit";
    case F::TellDark:
      return "tell dark";
    case F::TellConfirmed:
      return "tell confirmed";
    case F::TellUnconfirmed:
      return "tell unconfirmed";
    case F::ReportOverdue:
      return "report overdue";
    case F::ReportDark:
      return "report dark";
  }
  return "?";
}

}  // namespace contourd
