#include "daemon/print/manual_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = ManualState;
using E = ManualEvent;
using F = ManualEffect;

constexpr EnumSet<S> kUnmoved{S::PoweringOn, S::WarmingUp, S::Igniting, S::Lit, S::Asking};
constexpr auto kBeforeItsEnd = EnumSet<S>::all_except({S::Idle, S::Extinguishing});

constexpr auto kRows = std::to_array<ManualTransition>({
    {S::Idle, E::Home, S::Homing, F::Home},
    {S::Idle, E::Move, S::Moving, F::Move},
    {S::Idle, E::Nudge, S::Moving, F::Nudge},
    {S::Idle, E::PowerOn, S::PoweringOn, F::LightOff, F::PowerOn},
    {S::Idle, E::PowerOff, S::Extinguishing, F::LightOff, F::PowerOff, F::AwaitDark},
    {S::Idle, E::LightOn, S::WarmingUp, F::LightOff, F::PowerOn},
    {S::Idle, E::AskStatus, S::Asking, F::AskStatus},

    {S::Homing, E::Homed, S::Idle},
    {{S::Moving, S::Braking}, E::MoveEnded, S::Idle},
    {S::PoweringOn, E::ProjectorReady, S::Idle},
    {S::WarmingUp, E::ProjectorReady, S::Igniting, F::LightOn},
    {S::Igniting, E::LightOnSent, S::Lit, F::TimeLight},
    {S::Lit, E::TimeOver, S::Extinguishing, F::LightOff, F::AwaitDark},
    {S::Extinguishing, E::LightIsOff, S::Idle},
    {S::Extinguishing, E::GaveUp, S::Idle, F::LightOff, F::TellLightMayBeOn},
    {S::Asking, E::StatusTold, S::Idle},

    {{S::Homing, S::Moving}, E::Stop, S::Braking, F::LightOff, F::StopAxis},
    {kUnmoved, E::Stop, S::Extinguishing, F::LightOff, F::BlackNow, F::AwaitDark},

    {kBeforeItsEnd, E::Failed, S::Extinguishing, F::LightOff, F::BlackNow, F::AbortAxis, F::AwaitDark},
    // AwaitDark is in effect already.
    {S::Extinguishing, E::Failed, kStay, F::LightOff, F::BlackNow, F::AbortAxis},
});

// Braking and Extinguishing end by themselves.
constexpr auto kAnswered = std::to_array<StateTable<ManualTransition>::Answered>(
    {{E::Stop, {S::Idle, S::Braking, S::Extinguishing}}, {E::Failed, S::Idle}});

}  // namespace

const StateTable<ManualTransition>& manual_table() {
  static constexpr StateTable<ManualTransition> kTable{.rows = kRows,
                                                       .start = S::Idle,
                                                       .answered = kAnswered,
                                                       .light_on = F::LightOn,
                                                       .light_off = F::LightOff,
                                                       .harmless = F::TimeLight};
  return kTable;
}

}  // namespace contourd
