#include "daemon/print/continuous_states.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "daemon/print/layered_states.hpp"

namespace contourd {
namespace {

using S = ContinuousState;
using E = ContinuousEvent;
using F = ContinuousEffect;

// There may be light, or there will be, or the plate is not up for a pause.
constexpr EnumSet<S> kAtRest{S::Recovering, S::Settling, S::Showing, S::Igniting};
constexpr EnumSet<S> kMoving{S::Lowering, S::Rising, S::Slowing};
// These states already do what an interruption or a cancellation needs, apart from light and screen.
constexpr EnumSet<S> kGoingDark{S::Braking, S::Darkening, S::Lifting};
constexpr EnumSet<S> kStill{S::Paused, S::Parking, S::Ending};
constexpr auto kBeforeItsEnd = EnumSet<S>::all_except({S::Idle, S::Layering, S::Ending});

constexpr auto kRows = std::to_array<ContinuousTransition>({
    {S::Idle, E::Started, S::Layering, F::PrintLayers},
    {S::Layering, E::RiseDue, S::Lowering, F::LightOff, F::BlackNow, F::LowerToRise},
    {S::Layering, E::RestDue, S::Recovering, F::LightOff, F::BlackNow, F::AwaitOxygen},
    {S::Layering, E::LayeringEnded, S::Idle, F::Finish},

    {S::Recovering, E::WaitOver, S::Lowering, F::LowerToRise},
    {S::Lowering, E::MoveEnded, S::Settling, F::WaitToSettle},
    {S::Settling, E::WaitOver, S::Showing, F::ShowMask},
    {S::Showing, E::MaskShown, S::Igniting, F::LightOn},
    {S::Igniting, E::LightOnSent, S::Rising, F::Rise},
    {S::Rising, {E::MoveEnded, E::RiseBroken}, S::Darkening, F::LightOff, F::BlackNow, F::AwaitDark},
    {S::Rising, {E::TooFast, E::SpeedsChanged}, S::Slowing, F::StopAxis},
    {S::Slowing, E::SlowedDown, S::Rising, F::RiseOn},
    {S::Slowing, {E::MoveEnded, E::RiseBroken}, S::Darkening, F::LightOff, F::BlackNow, F::AwaitDark},
    {S::Darkening, E::LightIsOff, S::Lifting, F::Lift},

    // Goes on after the rise, or after a stop within it or before it.
    {S::Lifting, E::PauseDue, S::Paused},
    {{S::Lifting, S::Paused}, E::RiseDue, S::Lowering, F::LightOff, F::BlackNow, F::LowerToRise},
    {{S::Lifting, S::Paused}, E::RestDue, S::Recovering, F::LightOff, F::BlackNow, F::AwaitOxygen},
    {{S::Lifting, S::Paused}, E::LayersDue, S::Layering, F::LightOff, F::BlackNow, F::PrintMoreLayers},
    {S::Lifting, E::RisesOver, S::Parking, F::Park},
    {S::Parking, E::MoveEnded, S::Ending, F::LightOff, F::PowerOff, F::AwaitDark},
    {S::Ending, {E::LightIsOff, E::GaveUp}, S::Idle, F::Finish},

    // The light goes off at once; the plate moves up only when the light is confirmed off.
    {kMoving, {E::Interrupted, E::Canceled}, S::Braking, F::LightOff, F::BlackNow, F::StopAxis},
    {S::Braking, E::MoveEnded, S::Darkening, F::AwaitDark},
    {kAtRest, {E::Interrupted, E::Canceled}, S::Darkening, F::LightOff, F::BlackNow, F::AwaitDark},
    {kGoingDark, {E::Interrupted, E::Canceled}, kStay, F::LightOff, F::BlackNow},
    {kStill, E::Interrupted, kStay, F::LightOff, F::BlackNow},
    {S::Paused, E::Canceled, S::Parking, F::LightOff, F::BlackNow, F::Park},

    // The layered print has rows of its own for these, with the light off first.
    {S::Layering, E::Interrupted, kStay, F::InterruptLayers},
    {S::Layering, E::Canceled, kStay, F::CancelLayers},
    {S::Layering, E::Failed, kStay, F::FailLayers},

    {kBeforeItsEnd, E::Failed, S::Ending, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark},
});

// Parking and Ending end the print by themselves; a failure in Ending changes nothing.
constexpr auto kAnswered = std::to_array<StateTable<ContinuousTransition>::Answered>(
    {{E::Canceled, {S::Idle, S::Parking, S::Ending}},
     {E::Failed, {S::Idle, S::Ending}},
     {E::Interrupted, S::Idle}});

// Returns the cause of the time in a state that no layered print has.
TimeCause cause_of(S state) {
  if (EnumSet<S>{S::Rising, S::Slowing}.contains(state)) return TimeCause::Light;
  return state == S::Recovering ? TimeCause::Recovering : TimeCause::Switching;
}

PrintState print_state(S state) {
  const std::string_view name = name_of(state);
  const auto layered = layered_print_states();
  const auto same = std::ranges::find(layered, name, &PrintState::name);
  if (same != layered.end()) return *same;
  const std::size_t number = layered.size() + static_cast<std::size_t>(state);
  const bool lit = cause_of(state) == TimeCause::Light;
  return {number,
          name,
          lit ? PrintActivity::Exposing : PrintActivity::Waiting,
          EnumSet<S>{S::Recovering, S::Rising}.contains(state),
          false,
          cause_of(state)};
}

}  // namespace

std::span<const PrintState> continuous_print_states() {
  static const std::vector<PrintState> kStates = [] {
    std::vector<PrintState> states;
    for (std::size_t i = 0; i < kNames<S>.size(); ++i)
      states.push_back(print_state(S{static_cast<int>(i)}));
    return states;
  }();
  return kStates;
}

const StateTable<ContinuousTransition>& continuous_table() {
  static constexpr StateTable<ContinuousTransition> kTable{.rows = kRows,
                                                           .start = S::Idle,
                                                           .answered = kAnswered,
                                                           .light_on = F::LightOn,
                                                           .light_off = F::LightOff,
                                                           .harmless = {F::Rise, F::RiseOn, F::StopAxis}};
  return kTable;
}

}  // namespace contourd
