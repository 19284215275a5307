#include "hw/serial/projector_light_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ProjectorLightState;
using E = ProjectorLightEvent;
using F = ProjectorLightEffect;

constexpr auto kMayShine = EnumSet<S>::all_except({S::Dark, S::MakingSure, S::AskedWhetherOn});
constexpr EnumSet<S> kTurnedOff{S::MakingSure, S::TurningOff, S::Overdue};
// Neither a light on nor a light off is under way.
constexpr EnumSet<S> kNoCommand{S::Dark,     S::AskedWhetherOn,    S::Lit,
                                S::ComingUp, S::LitAskedWhetherOn, S::LostLit};
// There may be light, and no light off is under way.
constexpr EnumSet<S> kLeftLit{S::TurningOn, S::AskedWhetherLit,   S::Lit,
                              S::ComingUp,  S::LitAskedWhetherOn, S::LostLit};
constexpr EnumSet<S> kOverdue{S::Overdue, S::OverdueAskedWhetherOn, S::LostOverdue};
constexpr auto kNotOverdue = EnumSet<S>::all_except({S::Overdue, S::OverdueAskedWhetherOn, S::LostOverdue});
constexpr EnumSet<E> kUnconfirmed{E::LightOffUnanswered, E::LightOffFailed, E::LightOffGarbled};

// Light off was sent often enough: this is reported, and light off is tried on and on.
constexpr ProjectorLightTransition overdue(S from, EnumSet<E> on) {
  return {from, on, S::Overdue, F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed};
}
constexpr ProjectorLightTransition still_overdue(S from, EnumSet<E> on) {
  return {from, on, S::Overdue, F::RetryLater, F::DropLightOn, F::TellUnconfirmed};
}
constexpr ProjectorLightTransition confirmed(EnumSet<S> from, E on) {
  return {from, on, S::Dark, F::NoteDark, F::TellDark, F::TellConfirmed};
}
constexpr ProjectorLightTransition confirmed_at_last(S from, E on) {
  return {from, on, S::Dark, F::NoteDark, F::TellDark, F::ReportDark, F::TellConfirmed};
}

constexpr auto kRows = std::to_array<ProjectorLightTransition>({
    // Light on. From its first byte on the light counts as on.
    {kNoCommand, E::LightOnSent, S::TurningOn, F::NoteLightOn},
    // The light is meant to be off: a light on that slipped out is followed by a light off of its own.
    {S::MakingSure, E::LightOnSent, S::TurningOff, F::NoteLightOn, F::SendLightOff, F::TellUnlit},
    {{S::TurningOff, S::Overdue}, E::LightOnSent, kStay, F::NoteLightOn, F::SendLightOff, F::TellUnlit},
    {S::TurningOn, E::LightOnConfirmed, S::Lit, F::NoteLit, F::TellLit},
    {S::TurningOn, E::LightOnAmbiguous, S::Lit, F::TellLit},
    {S::TurningOn, E::LightOnUnanswered, S::AskedWhetherLit, F::AskWhetherLit},
    // A light on that is not confirmed may have been obeyed.
    {S::TurningOn, E::LightOnFailed, S::TurningOff, F::SendLightOff, F::TellUnlit},
    {S::AskedWhetherLit, E::SaysLit, S::Lit, F::NoteLit, F::TellLit},
    {S::AskedWhetherLit, E::SaysUnlit, S::TurningOff, F::SendLightOff, F::TellUnlit},
    // Light on was never sent.
    {{S::Dark, S::AskedWhetherOn}, E::LightOnFailed, S::MakingSure, F::SendLightOff, F::TellUnlit},

    // Power on may be obeyed without an answer.
    {S::Dark, E::PowerOnSent, S::ComingUp},
    {S::AskedWhetherOn, E::PowerOnSent, S::LitAskedWhetherOn},
    // Replies to a light off that was sent before power on do not count any more.
    {S::MakingSure, E::PowerOnSent, S::TurningOff, F::SendLightOff},
    {{S::TurningOff, S::Overdue}, E::PowerOnSent, kStay, F::SendLightOff},
    {{S::TurningOn, S::AskedWhetherLit}, E::Suspected, S::TurningOff, F::SendLightOff, F::TellUnlit},
    {kNoCommand, E::Suspected, S::TurningOff, F::SendLightOff},
    {S::MakingSure, E::Suspected, S::TurningOff, F::RepeatLightOff},
    {{S::TurningOff, S::Overdue}, E::Suspected, kStay, F::RepeatLightOff},
    {{S::OverdueAskedWhetherOn, S::LostOverdue}, E::Suspected, S::Overdue, F::SendLightOff},

    // Light off is sent in every state, whatever is known.
    {{S::Dark, S::AskedWhetherOn}, E::LightOffWanted, S::MakingSure, F::SendLightOff},
    {kLeftLit, E::LightOffWanted, S::TurningOff, F::SendLightOff},
    {{S::OverdueAskedWhetherOn, S::LostOverdue}, E::LightOffWanted, S::Overdue, F::SendLightOff},
    {kTurnedOff, {E::LightOffWanted, E::RetryDue}, kStay, F::RepeatLightOff},

    confirmed({S::MakingSure, S::TurningOff}, E::LightOffConfirmed),
    confirmed_at_last(S::Overdue, E::LightOffConfirmed),
    // The callback of when_dark() goes on waiting.
    {kTurnedOff, E::LightOffTooEarly, kStay, F::RetryLater},

    // There is no sign of light: the projector may be off.
    {S::MakingSure,
     {E::LightOffUnanswered, E::LightOffRefused},
     S::AskedWhetherOn,
     F::TellDark,
     F::AskWhetherOn},
    {S::MakingSure, E::LightOffFailed, S::Dark, F::TellDark, F::TellUnconfirmed},
    {S::MakingSure, {E::LightOffGarbled, E::LightOffUnclear}, S::TurningOff, F::SendLightOff},
    {S::MakingSure, E::LineLost, S::Dark, F::TellUnconfirmed},

    // There may be light: only a confirmation ends this, or the projector's answer that it is off.
    overdue(S::TurningOff, kUnconfirmed),
    {S::TurningOff, E::LightOffRefused, S::LitAskedWhetherOn, F::AskWhetherOn},
    {{S::TurningOff, S::Overdue}, E::LightOffUnclear, kStay, F::SendLightOff},
    {S::TurningOff, E::LineLost, S::LostLit, F::TellUnconfirmed},
    still_overdue(S::Overdue, kUnconfirmed),
    {S::Overdue, E::LightOffRefused, S::OverdueAskedWhetherOn, F::AskWhetherOn},
    {S::Overdue, E::LineLost, S::LostOverdue, F::TellUnconfirmed},

    confirmed({S::AskedWhetherOn, S::LitAskedWhetherOn}, E::SaysOff),
    {S::AskedWhetherOn, E::SaysOn, S::TurningOff, F::SendLightOff},
    {S::AskedWhetherOn, E::SaysNothing, S::Dark, F::TellUnconfirmed},
    {S::AskedWhetherOn, E::SaysTooEarly, S::MakingSure, F::RetryLater},
    overdue(S::LitAskedWhetherOn, {E::SaysOn, E::SaysNothing}),
    {S::LitAskedWhetherOn, E::SaysTooEarly, S::TurningOff, F::RetryLater},
    confirmed_at_last(S::OverdueAskedWhetherOn, E::SaysOff),
    still_overdue(S::OverdueAskedWhetherOn, {E::SaysOn, E::SaysNothing}),
    {S::OverdueAskedWhetherOn, E::SaysTooEarly, S::Overdue, F::RetryLater},
    // The answer came after a power off was confirmed.
    {S::Dark, E::SaysOn, S::TurningOff, F::SendLightOff},

    // A projector without power has no light.
    {kNotOverdue, E::PowerIsOff, S::Dark, F::StopSending, F::NoteDark, F::TellDark},
    {kOverdue, E::PowerIsOff, S::Dark, F::StopSending, F::NoteDark, F::TellDark, F::ReportDark},
});

constexpr auto kAnswered = std::to_array<StateTable<ProjectorLightTransition>::Answered>(
    {{E::LightOffWanted, {}}, {E::Suspected, {}}, {E::PowerIsOff, {}}});

}  // namespace

const StateTable<ProjectorLightTransition>& projector_light_table() {
  // NoteDark counts as light off: it only follows a confirmation.
  static constexpr StateTable<ProjectorLightTransition> kTable{
      .rows = kRows,
      .start = S::Dark,
      .answered = kAnswered,
      .light_on = F::NoteLightOn,
      .light_off = {F::SendLightOff, F::RepeatLightOff, F::NoteDark},
      .harmless = {F::NoteLightOn, F::NoteLit, F::TellLit, F::AskWhetherLit, F::StopSending}};
  return kTable;
}

bool may_shine(ProjectorLightState state) {
  return kMayShine.contains(state);
}

bool is_turned_off(ProjectorLightState state) {
  return kTurnedOff.contains(state);
}

bool is_overdue(ProjectorLightState state) {
  return kOverdue.contains(state);
}

}  // namespace contourd
