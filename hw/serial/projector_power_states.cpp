#include "hw/serial/projector_power_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ProjectorPowerState;
using E = ProjectorPowerEvent;
using F = ProjectorPowerEffect;

constexpr EnumSet<S> kOn{S::On, S::OnAsking, S::Darkening, S::SetsBrightness};
constexpr EnumSet<S> kOff{S::Off, S::OffAsking, S::OffCoolingDown};
constexpr EnumSet<S> kTurnedOff{S::TurningOff, S::OffOverdue};
constexpr EnumSet<S> kAsking{S::Asking, S::OffAsking, S::OnAsking};
// A power on that is dropped in these states leaves the projector's power unknown.
constexpr EnumSet<S> kComingOn{S::Asking,   S::CoolingDown, S::SwitchingOn, S::AskingReady,
                               S::StillOff, S::Unready,     S::OnWarmingUp};
// States in which no power on is pending.
constexpr EnumSet<S> kUnwanted{S::Unknown,         S::LeftOn,     S::Off,       S::On,
                               S::WarmingUpUnused, S::TurningOff, S::OffOverdue};
constexpr auto kMayBeOn =
    EnumSet<S>::all_except({S::Off, S::OffAsking, S::OffCoolingDown, S::TurningOff, S::OffOverdue});
// A projector that does not answer counts as not on, because some ignore questions while they are off.
constexpr EnumSet<E> kSaysNotOn{E::SaysOff, E::SaysUnclear, E::SaysNothing};

constexpr auto kRows = std::to_array<ProjectorPowerTransition>({
    {{S::Unknown, S::LeftOn, S::TurningOff, S::OffOverdue}, E::PowerOnWanted, S::Asking, F::AskWhetherOn},
    {S::Off, E::PowerOnWanted, S::OffAsking, F::AskWhetherOn},
    {S::On, E::PowerOnWanted, S::OnAsking, F::AskWhetherStillOn},
    {S::WarmingUpUnused, E::PowerOnWanted, S::WarmingUp, F::WaitUntilWarm},

    // The projector is on and warm; the state of its light is unknown.
    {kAsking, E::SaysOn, S::Darkening, F::WatchOver, F::MakeDark},
    {S::AskingReady, E::SaysOn, S::Darkening, F::WatchOver, F::MakeDark},
    {S::OnWarmingUp, E::Warm, S::Darkening, F::WatchOver, F::MakeDark},
    {kAsking, E::SaysOnEarly, S::OnWarmingUp, F::WaitUntilWarm},
    {{S::Asking, S::OnAsking}, kSaysNotOn, S::CoolingDown, F::WaitUntilCool},
    {S::OffAsking, kSaysNotOn, S::OffCoolingDown, F::WaitUntilCool},
    {{S::CoolingDown, S::OffCoolingDown}, E::Cool, S::SwitchingOn, F::SendPowerOn},
    {S::SwitchingOn, E::PowerOnAnswered, S::WarmingUp, F::WaitUntilWarm, F::SuspectLight},
    {S::SwitchingOn, E::PowerOnFailed, S::Unknown, F::Tell},
    {S::WarmingUp, E::Warm, S::AskingReady, F::AskWhetherReady},
    // The projector may have ignored power on because it was cooling down from before this program's start.
    {S::AskingReady, E::SaysOff, S::StillOff, F::Pause},
    {S::AskingReady, E::SaysUnclear, S::Unready, F::Pause},
    {S::AskingReady, E::SaysNothing, S::Unknown, F::Tell},
    {S::AskingReady, E::NeverOn, S::Unknown, F::TellNeverOn},
    {S::StillOff, E::PauseOver, S::SwitchingOn, F::SendPowerOn},
    {S::Unready, E::PauseOver, S::AskingReady, F::AskWhetherReady},
    {S::Darkening, E::LightIsOff, S::SetsBrightness, F::SetBrightness},
    {S::Darkening, E::LightOffFailed, S::On, F::Tell},
    {S::SetsBrightness, E::BrightnessAnswered, S::On, F::Tell},

    {kComingOn, E::Dropped, S::Unknown},
    {{S::OffAsking, S::OffCoolingDown}, E::Dropped, S::Off},
    {{S::OnAsking, S::Darkening, S::SetsBrightness}, E::Dropped, S::On},
    {S::WarmingUp, E::Dropped, S::WarmingUpUnused, F::WaitUntilWarm},
    {S::WarmingUpUnused, E::Warm, S::Unknown},

    {S::On, E::WentOff, S::Unknown, F::ReportWentOff},
    {S::OnAsking, E::WentOff, S::Asking, F::ReportWentOff},
    {{S::Darkening, S::SetsBrightness}, E::WentOff, S::Unknown, F::ReportWentOff, F::TellWentOff},

    {{S::Unknown, S::LeftOn}, E::LeftOnSuspected, S::LeftOn, F::AskWhetherLeftOn},
    {S::LeftOn, E::PauseOver, kStay, F::AskWhetherLeftOn},
    {S::LeftOn, E::SaysOn, S::TurningOff, F::LightOff, F::SendPowerOff},
    {S::LeftOn, E::NotOnYet, kStay, F::AskLeftOnSoon},
    // The projector may ignore questions while it is off, or its line is not plugged in yet.
    {S::LeftOn, E::SaysNothing, kStay, F::AskLeftOnLater},
    {S::LeftOn, {E::SaysOff, E::SaysUnclear, E::LineLost}, S::Unknown},

    // The light is turned off first.
    {kMayBeOn, E::PowerOffWanted, S::TurningOff, F::LightOff, F::SendPowerOff},
    {kOff, E::PowerOffWanted, S::Off, F::LightOff},
    {kTurnedOff, E::PowerOffWanted, kStay, F::LightOff},

    {kTurnedOff, E::PowerOffConfirmed, S::Off, F::NoteOff},
    {S::TurningOff, E::PowerOffUnanswered, kStay, F::PowerOffAgain, F::AskWhetherOff},
    {S::TurningOff, E::PowerOffLate, S::OffOverdue, F::ReportLampOn, F::PowerOffAgainLater, F::AskWhetherOff},
    {S::OffOverdue, {E::PowerOffUnanswered, E::PowerOffLate}, kStay, F::PowerOffAgainLater, F::AskWhetherOff},
    {kTurnedOff, E::PowerOffUnknowable, S::Unknown},
    {kTurnedOff, E::PauseOver, kStay, F::SendPowerOff},
    // Confirmation of a power off that was sent before power on was wanted.
    {S::Unknown, E::PowerOffConfirmed, S::Off, F::NoteOff},
    {S::Asking, E::PowerOffConfirmed, S::OffAsking, F::NoteOff},
    {S::CoolingDown, E::PowerOffConfirmed, S::OffCoolingDown, F::NoteOff, F::WaitUntilCool},
    {S::SwitchingOn, E::PowerOffConfirmed, S::OffCoolingDown, F::DropPowerOn, F::NoteOff, F::WaitUntilCool},
});

// A state without a pending power on has no command to drop.
constexpr auto kAnswered = std::to_array<StateTable<ProjectorPowerTransition>::Answered>(
    {{E::PowerOffWanted, {}}, {E::Dropped, kUnwanted}});

}  // namespace

const StateTable<ProjectorPowerTransition>& projector_power_table() {
  static constexpr StateTable<ProjectorPowerTransition> kTable{
      .rows = kRows, .start = S::Unknown, .answered = kAnswered, .light_off = F::LightOff};
  return kTable;
}

bool is_on(ProjectorPowerState state) {
  return kOn.contains(state);
}

bool is_off(ProjectorPowerState state) {
  return kOff.contains(state);
}

bool is_turned_off(ProjectorPowerState state) {
  return kTurnedOff.contains(state);
}

}  // namespace contourd
