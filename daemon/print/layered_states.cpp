#include "daemon/print/layered_states.hpp"

#include <array>

namespace contourd {
namespace {

using S = LayeredState;
using E = LayeredEvent;
using F = LayeredEffect;

// The plate rests in these states and can move up, so that the part can be taken off.
constexpr EnumSet<S> kAtRest{S::Settling, S::Showing, S::Resting, S::AwaitingDark, S::Paused};
constexpr EnumSet<S> kMoving{S::Lowering, S::Lifting, S::Raising, S::Braking};
constexpr EnumSet<S> kLit{S::Igniting, S::Exposing};
// The layer has had all its light, which may still be on.
constexpr EnumSet<S> kExposed{S::Darkening, S::Extinguishing};
// These states already do what an interruption needs, apart from light and screen.
constexpr EnumSet<S> kInterrupted{S::Interrupting, S::Lifting, S::Raising, S::Paused, S::Held,
                                  S::Braking,      S::Halting, S::Parking, S::Ending};
constexpr auto kBeforeItsEnd = EnumSet<S>::all_except({S::Idle, S::Ending});

constexpr auto kRows = std::to_array<LayeredTransition>({
    {S::Idle, E::Started, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn},
    {S::WarmingUp, E::ProjectorReady, S::Homing, F::Home},
    {S::Homing, E::Homed, S::AwaitingDark, F::AwaitDark},

    {S::Lowering, E::MoveEnded, S::Settling, F::WaitToSettle},
    {S::Settling, E::WaitOver, S::Showing, F::ShowMask},
    {S::Showing, E::MaskShown, S::Igniting, F::LightOn},
    {S::Igniting, E::LightOnSent, S::Exposing, F::TimeExposure},
    {S::Exposing, E::PictureDue, kStay, F::ShowPicture},
    {S::Exposing, E::WaitOver, S::Darkening, F::LightOff, F::ShowBlack},
    {S::Darkening, E::ScreenBlack, S::Extinguishing, F::AwaitDark},
    {S::Extinguishing, E::LightIsOff, S::Resting, F::RecordLayer, F::WaitToRest},
    {S::Resting, E::WaitOver, S::Lifting, F::Lift},
    {S::Lifting, E::MoveEnded, S::AwaitingDark, F::AwaitDark},

    {S::AwaitingDark, E::LayerDue, S::Lowering, F::RecordLayer, F::NextLayer, F::LowerToLayer},
    {S::AwaitingDark, E::LayerUnfinished, S::Lowering, F::LowerToLayer},
    {S::AwaitingDark, E::PauseDue, S::Raising, F::RaiseForALook},
    {S::AwaitingDark, E::LayersDone, S::Parking, F::RecordLayer, F::Park},

    // A rise takes over the machine as it is, and hands it back to the layers on top of it.
    {S::Idle, E::WentOn, S::AwaitingDark, F::LightOff, F::BlackNow, F::AwaitDark},
    {S::AwaitingDark, E::RiseDue, S::Idle, F::RecordLayer, F::Finish},

    {S::Raising, E::MoveEnded, S::Paused},
    {S::Paused, E::Resumed, S::AwaitingDark, F::AwaitDark},

    {S::Parking, E::MoveEnded, S::Ending, F::LightOff, F::PowerOff, F::AwaitDark},
    {S::Ending, {E::LightIsOff, E::GaveUp}, S::Idle, F::Finish},

    // Before the first layer there is nothing to peel off, and during homing there is no known height to go
    // to.
    {S::WarmingUp, E::Interrupted, S::Held, F::LightOff, F::BlackNow},
    {S::Homing, E::Interrupted, S::Held, F::LightOff, F::BlackNow, F::AbortAxis},
    {S::Held, E::Resumed, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn},
    {S::Lowering, E::Interrupted, S::Braking, F::LightOff, F::BlackNow, F::StopAxis},
    {S::Braking, E::MoveEnded, S::Lifting, F::Lift},
    // At a layer the plate is peeled off and moves up so that the user can look; the layer is continued
    // afterwards.
    {{S::Settling, S::Showing, S::Resting}, E::Interrupted, S::Lifting, F::LightOff, F::BlackNow, F::Lift},
    {S::AwaitingDark, E::Interrupted, S::Raising, F::LightOff, F::BlackNow, F::RaiseForALook},
    // While there may be light nothing moves before the light is confirmed off.
    {kLit, E::Interrupted, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark},
    {kExposed, E::Interrupted, S::Interrupting, F::LightOff, F::BlackNow, F::RecordLayer, F::AwaitDark},
    {S::Interrupting, E::LightIsOff, S::Lifting, F::Lift},
    {kInterrupted, E::Interrupted, kStay, F::LightOff, F::BlackNow},

    // During homing the plate's position is unknown, so the plate is left where it is.
    {{S::WarmingUp, S::Held}, E::Canceled, S::Ending, F::LightOff, F::BlackNow, F::PowerOff, F::AwaitDark},
    {S::Homing, E::Canceled, S::Ending, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark},
    {kMoving, E::Canceled, S::Halting, F::LightOff, F::BlackNow, F::StopAxis},
    {S::Halting, E::MoveEnded, S::Parking, F::Park},
    {kAtRest, E::Canceled, S::Parking, F::LightOff, F::BlackNow, F::Park},
    {kLit, E::Canceled, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark},
    {kExposed, E::Canceled, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark},
    // The plate is peeled off first; the cancellation is carried out in AwaitingDark.
    {S::Interrupting, E::Canceled, kStay, F::LightOff, F::BlackNow},

    // The light goes off before any effect that can fail. The job's files are moved once the light is
    // confirmed off, or the wait for that has timed out.
    {kBeforeItsEnd, E::Failed, S::Ending, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark},
});

// Halting, Parking and Ending end the print by themselves; a failure in Ending changes nothing.
constexpr auto kAnswered = std::to_array<StateTable<LayeredTransition>::Answered>(
    {{E::Canceled, {S::Idle, S::Halting, S::Parking, S::Ending}},
     {E::Failed, {S::Idle, S::Ending}},
     {E::Interrupted, S::Idle}});

constexpr EnumSet<S> kLogged{S::WarmingUp, S::Homing, S::Paused, S::Parking};

constexpr PrintActivity activity_of(S state) {
  if (EnumSet{S::WarmingUp, S::Homing}.contains(state)) return PrintActivity::Preparing;
  if (state == S::Exposing) return PrintActivity::Exposing;
  if (kMoving.contains(state) || state == S::Halting || state == S::Parking) return PrintActivity::Moving;
  if (EnumSet{S::Paused, S::Held}.contains(state)) return PrintActivity::Stopped;
  return PrintActivity::Waiting;
}

constexpr TimeCause cause_of(S state) {
  switch (state) {
    case S::WarmingUp:
      return TimeCause::WarmingUp;
    case S::Homing:
      return TimeCause::Homing;
    case S::Lowering:
      return TimeCause::Lowering;
    case S::Settling:
      return TimeCause::Settling;
    case S::Exposing:
      return TimeCause::Light;
    case S::Resting:
      return TimeCause::Resting;
    case S::Lifting:
      return TimeCause::Lifting;
    case S::Interrupting:
    case S::Raising:
    case S::Paused:
    case S::Held:
    case S::Braking:
    case S::Halting:
      return TimeCause::Stopped;
    case S::Parking:
      return TimeCause::Parking;
    default:
      return TimeCause::Switching;
  }
}

constexpr auto kPrintStates = [] {
  std::array<PrintState, kNames<S>.size()> states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const S state{static_cast<int>(i)};
    states[i] = {
        i, kNames<S>[i], activity_of(state), kLogged.contains(state), state == S::Ending, cause_of(state)};
  }
  return states;
}();
static_assert(kPrintStates.front() == kIdle);

}  // namespace

std::optional<PrintPhase> phase_of(LayeredState state) {
  switch (state) {
    case S::WarmingUp:
      return PrintPhase::Starting;
    case S::Lowering:
      return PrintPhase::Lowering;
    case S::Settling:
      return PrintPhase::BeforeLight;
    case S::Resting:
      return PrintPhase::Lit;
    case S::Lifting:
      return PrintPhase::Lifting;
    case S::Raising:
      return PrintPhase::Raising;
    case S::Paused:
      return PrintPhase::Paused;
    case S::Parking:
      return PrintPhase::Parking;
    default:
      return std::nullopt;
  }
}

std::span<const PrintState> layered_print_states() {
  return kPrintStates;
}

const StateTable<LayeredTransition>& layered_table() {
  static constexpr StateTable<LayeredTransition> kTable{.rows = kRows,
                                                        .start = S::Idle,
                                                        .answered = kAnswered,
                                                        .light_on = F::LightOn,
                                                        .light_off = F::LightOff,
                                                        .harmless = {F::TimeExposure, F::ShowPicture}};
  return kTable;
}

}  // namespace contourd
