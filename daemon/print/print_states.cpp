#include "daemon/print/print_states.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "daemon/print/manual_states.hpp"
#include "hw/gpio/homing_states.hpp"
#include "hw/serial/projector_light_states.hpp"
#include "hw/serial/projector_power_states.hpp"

namespace contourd {
namespace {

using S = PrintState;
using E = PrintEvent;
using F = PrintEffect;

constexpr auto kStates = names_to<S::Ending>(
    "idle, warming up, homing, lowering, settling, showing, igniting, exposing, darkening, extinguishing, "
    "interrupting, resting, lifting, awaiting dark, raising, paused, held, braking, halting, parking, "
    "ending");
constexpr auto kEvents = names_to<E::GaveUp>(
    "started, projector ready, homed, move ended, wait over, mask shown, light on sent, screen black, "
    "light is off, layer due, layer unfinished, pause due, layers done, interrupted, resumed, cancelled, "
    "failed, gave up");
constexpr auto kEffects = names_to<F::Finish>(
    "light off, black now, abort axis, stop axis, power on, power off, home, lower to layer, "
    "wait to settle, show mask, light on, time exposure, show black, await dark, record layer, "
    "wait to rest, lift, next layer, raise for a look, park, finish");

// Nothing moves in these states, and the plate can move up so that the part can be taken off.
constexpr EnumSet<S> kAtRest{S::Settling, S::Showing, S::Resting, S::AwaitingDark, S::Paused};
constexpr EnumSet<S> kMoving{S::Lowering, S::Lifting, S::Raising, S::Braking};
constexpr EnumSet<S> kLit{S::Igniting, S::Exposing};
// The layer has had all its light, which may still be on.
constexpr EnumSet<S> kExposed{S::Darkening, S::Extinguishing};
// These states already do what an interruption needs, apart from light and screen.
constexpr EnumSet<S> kInterrupted{S::Interrupting, S::Lifting, S::Raising, S::Paused, S::Held,
                                  S::Braking,      S::Halting, S::Parking, S::Ending};
constexpr auto kBeforeItsEnd = EnumSet<S>::all_except({S::Idle, S::Ending});

constexpr auto kRows = std::to_array<PrintTransition>({
    {S::Idle, E::Started, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn},
    {S::WarmingUp, E::ProjectorReady, S::Homing, F::Home},
    {S::Homing, E::Homed, S::AwaitingDark, F::AwaitDark},

    {S::Lowering, E::MoveEnded, S::Settling, F::WaitToSettle},
    {S::Settling, E::WaitOver, S::Showing, F::ShowMask},
    {S::Showing, E::MaskShown, S::Igniting, F::LightOn},
    {S::Igniting, E::LightOnSent, S::Exposing, F::TimeExposure},
    {S::Exposing, E::WaitOver, S::Darkening, F::LightOff, F::ShowBlack},
    {S::Darkening, E::ScreenBlack, S::Extinguishing, F::AwaitDark},
    {S::Extinguishing, E::LightIsOff, S::Resting, F::RecordLayer, F::WaitToRest},
    {S::Resting, E::WaitOver, S::Lifting, F::Lift},
    {S::Lifting, E::MoveEnded, S::AwaitingDark, F::AwaitDark},

    {S::AwaitingDark, E::LayerDue, S::Lowering, F::RecordLayer, F::NextLayer, F::LowerToLayer},
    {S::AwaitingDark, E::LayerUnfinished, S::Lowering, F::LowerToLayer},
    {S::AwaitingDark, E::PauseDue, S::Raising, F::RaiseForALook},
    {S::AwaitingDark, E::LayersDone, S::Parking, F::RecordLayer, F::Park},

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
constexpr auto kAnswered = std::to_array<StateTable<PrintTransition>::Answered>(
    {{E::Canceled, {S::Idle, S::Halting, S::Parking, S::Ending}},
     {E::Failed, {S::Idle, S::Ending}},
     {E::Interrupted, S::Idle}});

}  // namespace

const StateTable<PrintTransition>& print_table() {
  static constexpr StateTable<PrintTransition> kTable{.rows = kRows,
                                                      .states = kStates,
                                                      .events = kEvents,
                                                      .start = S::Idle,
                                                      .answered = kAnswered,
                                                      .light_on = F::LightOn,
                                                      .light_off = F::LightOff,
                                                      .harmless = F::TimeExposure};
  return kTable;
}

std::string_view name_of(PrintState state) {
  return name_in<PrintState>(kStates, state);
}

std::string_view name_of(PrintEvent event) {
  return name_in<PrintEvent>(kEvents, event);
}

std::string_view name_of(PrintEffect effect) {
  return name_in<PrintEffect>(kEffects, effect);
}

std::string draw_print_states() {
  std::string graph =
      "digraph print {\n  node [shape=box, style=rounded];\n  \"any state\" [style=dashed];\n";
  bool failure_drawn = false;
  for_each_transition(print_table(), [&](S from, E on, const PrintTransition& row) {
    if (on == E::Failed && std::exchange(failure_drawn, true)) return;
    graph +=
        fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"];\n", on == E::Failed ? "any state" : name_of(from),
                    name_of(row.next(from)), label_of(on, row));
  });
  graph += draw_table("by hand", manual_table());
  graph += draw_table("homing", homing_table());
  graph += draw_table("projector power", projector_power_table());
  graph += draw_table("projector light", projector_light_table());
  return graph + "}\n";
}

}  // namespace contourd
