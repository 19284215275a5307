#include "hw/serial/projector_power_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ProjectorPowerState;
using E = ProjectorPowerEvent;
using F = ProjectorPowerEffect;

template <typename... Effects>
constexpr ProjectorPowerTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= ProjectorPowerTransition::kMaxEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

// The projector is on and warm; the state of its light is unknown.
constexpr ProjectorPowerTransition on(S from, E event) {
  return row(from, event, S::Darkening, F::WatchOver, F::MakeDark);
}

// A projector that does not answer counts as not on, because some ignore questions while they are off.
constexpr ProjectorPowerTransition not_on(S from, E event, S to) {
  return row(from, event, to, F::WaitUntilCool);
}

// The light is turned off first.
constexpr ProjectorPowerTransition turn_off(S from) {
  return row(from, E::PowerOffWanted, S::TurningOff, F::LightOff, F::SendPowerOff);
}

constexpr ProjectorPowerTransition keep_off(S from, S to) {
  return row(from, E::PowerOffWanted, to, F::LightOff);
}

constexpr ProjectorPowerTransition went_off(S from) {
  return row(from, E::WentOff, S::Unknown, F::ReportWentOff, F::TellWentOff);
}

constexpr auto kTable = std::to_array<ProjectorPowerTransition>({
    row(S::Unknown, E::PowerOnWanted, S::Asking, F::AskWhetherOn),
    row(S::LeftOn, E::PowerOnWanted, S::Asking, F::AskWhetherOn),
    row(S::Off, E::PowerOnWanted, S::OffAsking, F::AskWhetherOn),
    row(S::On, E::PowerOnWanted, S::OnAsking, F::AskWhetherStillOn),
    row(S::WarmingUpUnused, E::PowerOnWanted, S::WarmingUp, F::WaitUntilWarm),
    row(S::TurningOff, E::PowerOnWanted, S::Asking, F::AskWhetherOn),
    row(S::OffOverdue, E::PowerOnWanted, S::Asking, F::AskWhetherOn),

    on(S::Asking, E::SaysOn),
    on(S::OffAsking, E::SaysOn),
    on(S::OnAsking, E::SaysOn),
    row(S::Asking, E::SaysOnEarly, S::OnWarmingUp, F::WaitUntilWarm),
    row(S::OffAsking, E::SaysOnEarly, S::OnWarmingUp, F::WaitUntilWarm),
    row(S::OnAsking, E::SaysOnEarly, S::OnWarmingUp, F::WaitUntilWarm),
    not_on(S::Asking, E::SaysOff, S::CoolingDown),
    not_on(S::Asking, E::SaysUnclear, S::CoolingDown),
    not_on(S::Asking, E::SaysNothing, S::CoolingDown),
    not_on(S::OnAsking, E::SaysOff, S::CoolingDown),
    not_on(S::OnAsking, E::SaysUnclear, S::CoolingDown),
    not_on(S::OnAsking, E::SaysNothing, S::CoolingDown),
    not_on(S::OffAsking, E::SaysOff, S::OffCoolingDown),
    not_on(S::OffAsking, E::SaysUnclear, S::OffCoolingDown),
    not_on(S::OffAsking, E::SaysNothing, S::OffCoolingDown),
    row(S::CoolingDown, E::Cool, S::SwitchingOn, F::SendPowerOn),
    row(S::OffCoolingDown, E::Cool, S::SwitchingOn, F::SendPowerOn),
    row(S::SwitchingOn, E::PowerOnAnswered, S::WarmingUp, F::WaitUntilWarm, F::SuspectLight),
    row(S::SwitchingOn, E::PowerOnFailed, S::Unknown, F::Tell),
    row(S::WarmingUp, E::Warm, S::AskingReady, F::AskWhetherReady),
    on(S::OnWarmingUp, E::Warm),
    on(S::AskingReady, E::SaysOn),
    // The projector may have ignored power on because it was cooling down from before this program's start.
    row(S::AskingReady, E::SaysOff, S::StillOff, F::Pause),
    row(S::AskingReady, E::SaysUnclear, S::Unready, F::Pause),
    row(S::AskingReady, E::SaysNothing, S::Unknown, F::Tell),
    row(S::AskingReady, E::NeverOn, S::Unknown, F::TellNeverOn),
    row(S::StillOff, E::PauseOver, S::SwitchingOn, F::SendPowerOn),
    row(S::Unready, E::PauseOver, S::AskingReady, F::AskWhetherReady),
    row(S::Darkening, E::LightIsOff, S::SetsBrightness, F::SetBrightness),
    row(S::Darkening, E::LightOffFailed, S::On, F::Tell),
    row(S::SetsBrightness, E::BrightnessAnswered, S::On, F::Tell),

    row(S::Asking, E::Dropped, S::Unknown),
    row(S::OffAsking, E::Dropped, S::Off),
    row(S::OnAsking, E::Dropped, S::On),
    row(S::CoolingDown, E::Dropped, S::Unknown),
    row(S::OffCoolingDown, E::Dropped, S::Off),
    row(S::SwitchingOn, E::Dropped, S::Unknown),
    row(S::WarmingUp, E::Dropped, S::WarmingUpUnused, F::WaitUntilWarm),
    row(S::WarmingUpUnused, E::Warm, S::Unknown),
    row(S::AskingReady, E::Dropped, S::Unknown),
    row(S::StillOff, E::Dropped, S::Unknown),
    row(S::Unready, E::Dropped, S::Unknown),
    row(S::OnWarmingUp, E::Dropped, S::Unknown),
    row(S::Darkening, E::Dropped, S::On),
    row(S::SetsBrightness, E::Dropped, S::On),

    row(S::On, E::WentOff, S::Unknown, F::ReportWentOff),
    row(S::OnAsking, E::WentOff, S::Asking, F::ReportWentOff),
    went_off(S::Darkening),
    went_off(S::SetsBrightness),

    row(S::Unknown, E::LeftOnSuspected, S::LeftOn, F::AskWhetherLeftOn),
    row(S::LeftOn, E::LeftOnSuspected, S::LeftOn, F::AskWhetherLeftOn),
    row(S::LeftOn, E::PauseOver, S::LeftOn, F::AskWhetherLeftOn),
    row(S::LeftOn, E::SaysOn, S::TurningOff, F::LightOff, F::SendPowerOff),
    row(S::LeftOn, E::NotOnYet, S::LeftOn, F::AskLeftOnSoon),
    // The projector may ignore questions while it is off, or its line is not plugged in yet.
    row(S::LeftOn, E::SaysNothing, S::LeftOn, F::AskLeftOnLater),
    row(S::LeftOn, E::SaysOff, S::Unknown),
    row(S::LeftOn, E::SaysUnclear, S::Unknown),
    row(S::LeftOn, E::LineLost, S::Unknown),

    turn_off(S::Unknown),
    turn_off(S::LeftOn),
    turn_off(S::Asking),
    turn_off(S::OnAsking),
    turn_off(S::CoolingDown),
    turn_off(S::SwitchingOn),
    turn_off(S::WarmingUp),
    turn_off(S::AskingReady),
    turn_off(S::StillOff),
    turn_off(S::Unready),
    turn_off(S::OnWarmingUp),
    turn_off(S::Darkening),
    turn_off(S::SetsBrightness),
    turn_off(S::On),
    turn_off(S::WarmingUpUnused),
    keep_off(S::Off, S::Off),
    keep_off(S::OffAsking, S::Off),
    keep_off(S::OffCoolingDown, S::Off),
    keep_off(S::TurningOff, S::TurningOff),
    keep_off(S::OffOverdue, S::OffOverdue),

    row(S::TurningOff, E::PowerOffConfirmed, S::Off, F::NoteOff),
    row(S::TurningOff, E::PowerOffUnanswered, S::TurningOff, F::PowerOffAgain, F::AskWhetherOff),
    row(S::TurningOff, E::PowerOffLate, S::OffOverdue, F::ReportLampOn, F::PowerOffAgainLater,
        F::AskWhetherOff),
    row(S::TurningOff, E::PowerOffUnknowable, S::Unknown),
    row(S::TurningOff, E::PauseOver, S::TurningOff, F::SendPowerOff),
    row(S::OffOverdue, E::PowerOffConfirmed, S::Off, F::NoteOff),
    row(S::OffOverdue, E::PowerOffUnanswered, S::OffOverdue, F::PowerOffAgainLater, F::AskWhetherOff),
    row(S::OffOverdue, E::PowerOffLate, S::OffOverdue, F::PowerOffAgainLater, F::AskWhetherOff),
    row(S::OffOverdue, E::PowerOffUnknowable, S::Unknown),
    row(S::OffOverdue, E::PauseOver, S::OffOverdue, F::SendPowerOff),
    // Confirmation of a power off that was sent before power on was wanted.
    row(S::Unknown, E::PowerOffConfirmed, S::Off, F::NoteOff),
    row(S::Asking, E::PowerOffConfirmed, S::OffAsking, F::NoteOff),
    row(S::CoolingDown, E::PowerOffConfirmed, S::OffCoolingDown, F::NoteOff, F::WaitUntilCool),
    row(S::SwitchingOn, E::PowerOffConfirmed, S::OffCoolingDown, F::DropPowerOn, F::NoteOff,
        F::WaitUntilCool),
});

}  // namespace

std::span<const ProjectorPowerTransition> projector_power_transitions() {
  return kTable;
}

bool is_on(ProjectorPowerState state) {
  return state == S::On || state == S::OnAsking || state == S::Darkening || state == S::SetsBrightness;
}

bool is_off(ProjectorPowerState state) {
  return state == S::Off || state == S::OffAsking || state == S::OffCoolingDown;
}

bool is_turned_off(ProjectorPowerState state) {
  return state == S::TurningOff || state == S::OffOverdue;
}

std::string_view name_of(ProjectorPowerState state) {
  switch (state) {
    case S::Unknown:
      return "unknown";
    case S::LeftOn:
      return "left on";
    case S::Off:
      return "off";
    case S::Asking:
      return "asking";
    case S::OffAsking:
      return "off asking";
    case S::OnAsking:
      return "on asking";
    case S::CoolingDown:
      return "cooling down";
    case S::OffCoolingDown:
      return "off cooling down";
    case S::SwitchingOn:
      return "switching on";
    case S::WarmingUp:
      return "warming up";
    case S::AskingReady:
      return "asking ready";
    case S::StillOff:
      return "still off";
    case S::Unready:
      return "unready";
    case S::OnWarmingUp:
      return "on warming up";
    case S::Darkening:
      return "darkening";
    case S::SetsBrightness:
      return "sets brightness";
    case S::On:
      return "on";
    case S::WarmingUpUnused:
      return "warming up unused";
    case S::TurningOff:
      return "turning off";
    case S::OffOverdue:
      return "off overdue";
  }
  return "?";
}

std::string_view name_of(ProjectorPowerEvent event) {
  switch (event) {
    case E::PowerOnWanted:
      return "power on wanted";
    case E::Dropped:
      return "dropped";
    case E::PowerOffWanted:
      return "power off wanted";
    case E::LeftOnSuspected:
      return "left on suspected";
    case E::SaysOn:
      return "says on";
    case E::SaysOnEarly:
      return "says on early";
    case E::SaysOff:
      return "says off";
    case E::SaysUnclear:
      return "says unclear";
    case E::SaysNothing:
      return "says nothing";
    case E::NeverOn:
      return "never on";
    case E::NotOnYet:
      return "not on yet";
    case E::LineLost:
      return "line lost";
    case E::Cool:
      return "cool";
    case E::Warm:
      return "warm";
    case E::PauseOver:
      return "pause over";
    case E::PowerOnAnswered:
      return "power on answered";
    case E::PowerOnFailed:
      return "power on failed";
    case E::LightIsOff:
      return "light is off";
    case E::LightOffFailed:
      return "light off failed";
    case E::BrightnessAnswered:
      return "brightness answered";
    case E::WentOff:
      return "went off";
    case E::PowerOffConfirmed:
      return "power off confirmed";
    case E::PowerOffUnanswered:
      return "power off unanswered";
    case E::PowerOffLate:
      return "power off late";
    case E::PowerOffUnknowable:
      return "power off unknowable";
  }
  return "?";
}

std::string_view name_of(ProjectorPowerEffect effect) {
  switch (effect) {
    case F::LightOff:
      return "light off";
    case F::AskWhetherOn:
      return "ask whether on";
    case F::AskWhetherStillOn:
      return "ask whether still on";
    case F::AskWhetherReady:
      return "ask whether ready";
    case F::AskWhetherLeftOn:
      return "ask whether left on";
    case F::AskLeftOnSoon:
      return "ask left on soon";
    case F::AskLeftOnLater:
      return "ask left on later";
    case F::WaitUntilCool:
      return "wait until cool";
    case F::SendPowerOn:
      return "send power on";
    case F::DropPowerOn:
      return "drop power on";
    case F::SuspectLight:
      return "suspect light";
    case F::WaitUntilWarm:
      return "wait until warm";
    case F::Pause:
      return "pause";
    case F::WatchOver:
      return "watch over";
    case F::MakeDark:
      return "make dark";
    case F::SetBrightness:
      return "set brightness";
    case F::SendPowerOff:
      return "send power off";
    case F::AskWhetherOff:
      return "ask whether off";
    case F::PowerOffAgain:
      return "power off again";
    case F::PowerOffAgainLater:
      return "power off again later";
    case F::NoteOff:
      return "note off";
    case F::Tell:
      return "tell";
    case F::TellNeverOn:
      return "tell never on";
    case F::TellWentOff:
      return "tell went off";
    case F::ReportWentOff:
      return "report went off";
    case F::ReportLampOn:
      return "report lamp on";
  }
  return "?";
}

}  // namespace contourd
