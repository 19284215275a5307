#include "hw/gpio/homing_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = HomingState;
using E = HomingEvent;
using F = HomingEffect;

constexpr EnumSet<S> kPasses{S::FastPass, S::FastPassOver, S::SlowPass, S::SlowPassOver, S::PassStopping};
constexpr EnumSet<S> kOutsidePasses{S::GettingReady, S::BackingOff,  S::BackedOff,
                                    S::AtSwitch,     S::Approaching, S::Stopping};
constexpr auto kUnderWay = EnumSet<S>::all_except({S::Idle});

constexpr auto kRows = std::to_array<HomingTransition>({
    {S::Idle, E::HomeWanted, S::GettingReady, F::ForgetPosition, F::GetReady},
    {S::GettingReady, E::SwitchOpen, S::FastPass, F::SeekFast},
    {S::GettingReady, E::SwitchClosed, S::BackingOff, F::BackOff},

    {{S::FastPass, S::FastPassOver}, E::Contact, S::BackingOff, F::BackOff},
    {{S::FastPass, S::FastPassOver}, E::Spike, S::FastPass, F::SeekOn},
    {S::FastPass, E::WayOver, S::FastPassOver, F::AwaitContact},
    {{S::FastPassOver, S::SlowPassOver}, E::WaitOver, S::Idle, F::TellNoTrigger},

    {S::BackingOff, E::WayOver, S::BackedOff, F::LookAtSwitch},
    {S::BackedOff, E::SwitchOpen, S::SlowPass, F::SeekSlow},
    {S::BackedOff, E::SwitchClosed, S::Idle, F::TellStillClosed},

    {{S::SlowPass, S::SlowPassOver}, E::Contact, S::AtSwitch, F::TakePosition, F::AwaitRest},
    {{S::SlowPass, S::SlowPassOver}, E::Spike, S::SlowPass, F::SeekOn},
    {S::SlowPass, E::WayOver, S::SlowPassOver, F::AwaitContact},

    {S::AtSwitch, E::WaitOver, S::Approaching, F::KnowPosition, F::Approach},
    {S::Approaching, E::Arrived, S::Idle, F::TellHomed},

    {kPasses, E::StopWanted, S::PassStopping, F::StopMotor},
    {kOutsidePasses, E::StopWanted, S::Stopping, F::StopMotor},
    {S::PassStopping, {E::Contact, E::Spike, E::Stopped}, S::Idle, F::TellStopped},
    {S::Stopping, E::Stopped, S::Idle, F::TellStopped},

    {kUnderWay, E::Failed, S::Idle, F::TellFailed},
    {kUnderWay, E::Aborted, S::Idle, F::DropAnswer},
});

constexpr auto kAnswered = std::to_array<StateTable<HomingTransition>::Answered>(
    {{E::StopWanted, S::Idle}, {E::Failed, S::Idle}, {E::Aborted, S::Idle}});

}  // namespace

const StateTable<HomingTransition>& homing_table() {
  static constexpr StateTable<HomingTransition> kTable{
      .rows = kRows, .start = S::Idle, .answered = kAnswered};
  return kTable;
}

bool is_in_pass(HomingState state) {
  return kPasses.contains(state);
}

}  // namespace contourd
