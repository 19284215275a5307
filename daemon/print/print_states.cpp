#include "daemon/print/print_states.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/print/manual_states.hpp"
#include "hw/gpio/homing_states.hpp"
#include "hw/serial/projector_light_states.hpp"
#include "hw/serial/projector_power_states.hpp"

namespace contourd {
namespace {

using S = PrintState;
using E = PrintEvent;
using F = PrintEffect;

template <typename... Effects>
constexpr PrintTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= PrintTransition::kMaxEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

// Turns the light off before any effect that can fail, then stops the motor and powers the lamp off. The
// job's files are moved once the light is confirmed off, or the wait for that has timed out.
constexpr PrintTransition failure(S from) {
  return row(from, E::Failed, S::Ending, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark);
}

// Cancels a print while nothing moves: the plate moves up so that the part can be taken off.
constexpr PrintTransition cancel_at_rest(S from) {
  return row(from, E::Canceled, S::Parking, F::LightOff, F::BlackNow, F::Park);
}

// Interrupts or cancels a print while there may be light: nothing moves before the light is confirmed off.
constexpr PrintTransition interruption_lit(S from, E on) {
  return row(from, on, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark);
}

constexpr PrintTransition cancel_moving(S from) {
  return row(from, E::Canceled, S::Halting, F::LightOff, F::BlackNow, F::StopAxis);
}

// Interrupts a print at a layer: the plate is peeled off and moves up so that the user can look; the layer is
// continued afterwards.
constexpr PrintTransition interruption_at_rest(S from) {
  return row(from, E::Interrupted, S::Lifting, F::LightOff, F::BlackNow, F::Lift);
}

// Interrupts a print while the plate is up already.
constexpr PrintTransition interruption_above_resin(S from) {
  return row(from, E::Interrupted, S::Raising, F::LightOff, F::BlackNow, F::RaiseForALook);
}

// Interrupts a print in a state that already does everything necessary, apart from light and screen.
constexpr PrintTransition interruption_unmoved(S in) {
  return row(in, E::Interrupted, in, F::LightOff, F::BlackNow);
}

constexpr auto kTable = std::to_array<PrintTransition>({
    row(S::Idle, E::Started, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn),
    row(S::WarmingUp, E::ProjectorReady, S::Homing, F::Home),
    row(S::Homing, E::Homed, S::AwaitingDark, F::AwaitDark),

    row(S::Lowering, E::MoveEnded, S::Settling, F::WaitToSettle),
    row(S::Settling, E::WaitOver, S::Showing, F::ShowMask),
    row(S::Showing, E::MaskShown, S::Igniting, F::LightOn),
    row(S::Igniting, E::LightOnSent, S::Exposing, F::TimeExposure),
    row(S::Exposing, E::WaitOver, S::Darkening, F::LightOff, F::ShowBlack),
    row(S::Darkening, E::ScreenBlack, S::Extinguishing, F::AwaitDark),
    row(S::Extinguishing, E::LightIsOff, S::Resting, F::RecordLayer, F::WaitToRest),
    row(S::Resting, E::WaitOver, S::Lifting, F::Lift),
    row(S::Lifting, E::MoveEnded, S::AwaitingDark, F::AwaitDark),

    row(S::AwaitingDark, E::LayerDue, S::Lowering, F::RecordLayer, F::NextLayer, F::LowerToLayer),
    row(S::AwaitingDark, E::LayerUnfinished, S::Lowering, F::LowerToLayer),
    row(S::AwaitingDark, E::PauseDue, S::Raising, F::RaiseForALook),
    row(S::AwaitingDark, E::LayersDone, S::Parking, F::RecordLayer, F::Park),

    row(S::Raising, E::MoveEnded, S::Paused),
    row(S::Paused, E::Resumed, S::AwaitingDark, F::AwaitDark),

    row(S::Parking, E::MoveEnded, S::Ending, F::LightOff, F::PowerOff, F::AwaitDark),
    row(S::Ending, E::LightIsOff, S::Idle, F::Finish),
    row(S::Ending, E::GaveUp, S::Idle, F::Finish),

    // Before the first layer there is nothing to peel off, and during homing there is no known height to go
    // to.
    row(S::WarmingUp, E::Interrupted, S::Held, F::LightOff, F::BlackNow),
    row(S::Homing, E::Interrupted, S::Held, F::LightOff, F::BlackNow, F::AbortAxis),
    row(S::Held, E::Resumed, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn),
    row(S::Lowering, E::Interrupted, S::Braking, F::LightOff, F::BlackNow, F::StopAxis),
    row(S::Braking, E::MoveEnded, S::Lifting, F::Lift),
    interruption_at_rest(S::Settling),
    interruption_at_rest(S::Showing),
    interruption_lit(S::Igniting, E::Interrupted),
    interruption_lit(S::Exposing, E::Interrupted),
    // The layer has had all its light.
    row(S::Darkening, E::Interrupted, S::Interrupting, F::LightOff, F::BlackNow, F::RecordLayer,
        F::AwaitDark),
    row(S::Extinguishing, E::Interrupted, S::Interrupting, F::LightOff, F::BlackNow, F::RecordLayer,
        F::AwaitDark),
    interruption_unmoved(S::Interrupting),
    row(S::Interrupting, E::LightIsOff, S::Lifting, F::Lift),
    interruption_at_rest(S::Resting),
    interruption_unmoved(S::Lifting),
    interruption_above_resin(S::AwaitingDark),
    interruption_unmoved(S::Raising),
    interruption_unmoved(S::Paused),
    interruption_unmoved(S::Held),
    interruption_unmoved(S::Braking),
    interruption_unmoved(S::Halting),
    interruption_unmoved(S::Parking),
    interruption_unmoved(S::Ending),

    // During homing the plate's position is unknown, so the plate is left where it is.
    row(S::WarmingUp, E::Canceled, S::Ending, F::LightOff, F::BlackNow, F::PowerOff, F::AwaitDark),
    row(S::Homing, E::Canceled, S::Ending, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark),
    row(S::Held, E::Canceled, S::Ending, F::LightOff, F::BlackNow, F::PowerOff, F::AwaitDark),
    cancel_moving(S::Lowering),
    cancel_moving(S::Lifting),
    cancel_moving(S::Raising),
    cancel_moving(S::Braking),
    row(S::Halting, E::MoveEnded, S::Parking, F::Park),
    cancel_at_rest(S::Settling),
    cancel_at_rest(S::Showing),
    interruption_lit(S::Igniting, E::Canceled),
    interruption_lit(S::Exposing, E::Canceled),
    interruption_lit(S::Darkening, E::Canceled),
    interruption_lit(S::Extinguishing, E::Canceled),
    // The plate is peeled off first; the cancellation is carried out in AwaitingDark.
    row(S::Interrupting, E::Canceled, S::Interrupting, F::LightOff, F::BlackNow),
    cancel_at_rest(S::Resting),
    cancel_at_rest(S::AwaitingDark),
    cancel_at_rest(S::Paused),

    failure(S::WarmingUp),
    failure(S::Homing),
    failure(S::Lowering),
    failure(S::Settling),
    failure(S::Showing),
    failure(S::Igniting),
    failure(S::Exposing),
    failure(S::Darkening),
    failure(S::Extinguishing),
    failure(S::Interrupting),
    failure(S::Resting),
    failure(S::Lifting),
    failure(S::AwaitingDark),
    failure(S::Raising),
    failure(S::Paused),
    failure(S::Held),
    failure(S::Braking),
    failure(S::Halting),
    failure(S::Parking),
});

}  // namespace

std::span<const PrintTransition> print_transitions() {
  return kTable;
}

const PrintTransition* find_transition(PrintState from, PrintEvent on) {
  const auto found = std::find_if(kTable.begin(), kTable.end(),
                                  [&](const PrintTransition& t) { return t.from == from && t.on == on; });
  return found != kTable.end() ? &*found : nullptr;
}

std::string_view name_of(PrintState state) {
  switch (state) {
    case S::Idle:
      return "idle";
    case S::WarmingUp:
      return "warming up";
    case S::Homing:
      return "homing";
    case S::Lowering:
      return "lowering";
    case S::Settling:
      return "settling";
    case S::Showing:
      return "showing";
    case S::Igniting:
      return "igniting";
    case S::Exposing:
      return "exposing";
    case S::Darkening:
      return "darkening";
    case S::Extinguishing:
      return "extinguishing";
    case S::Interrupting:
      return "interrupting";
    case S::Resting:
      return "resting";
    case S::Lifting:
      return "lifting";
    case S::AwaitingDark:
      return "awaiting dark";
    case S::Raising:
      return "raising";
    case S::Paused:
      return "paused";
    case S::Held:
      return "held";
    case S::Braking:
      return "braking";
    case S::Halting:
      return "halting";
    case S::Parking:
      return "parking";
    case S::Ending:
      return "ending";
  }
  return "?";
}

std::string_view name_of(PrintEvent event) {
  switch (event) {
    case E::Started:
      return "started";
    case E::ProjectorReady:
      return "projector ready";
    case E::Homed:
      return "homed";
    case E::MoveEnded:
      return "move ended";
    case E::WaitOver:
      return "wait over";
    case E::MaskShown:
      return "mask shown";
    case E::LightOnSent:
      return "light on sent";
    case E::ScreenBlack:
      return "screen black";
    case E::LightIsOff:
      return "light is off";
    case E::LayerDue:
      return "layer due";
    case E::LayerUnfinished:
      return "layer unfinished";
    case E::PauseDue:
      return "pause due";
    case E::LayersDone:
      return "layers done";
    case E::Interrupted:
      return "interrupted";
    case E::Resumed:
      return "resumed";
    case E::Canceled:
      return "cancelled";
    case E::Failed:
      return "failed";
    case E::GaveUp:
      return "gave up";
  }
  return "?";
}

std::string_view name_of(PrintEffect effect) {
  switch (effect) {
    case F::LightOff:
      return "light off";
    case F::BlackNow:
      return "black now";
    case F::AbortAxis:
      return "abort axis";
    case F::StopAxis:
      return "stop axis";
    case F::PowerOn:
      return "power on";
    case F::PowerOff:
      return "power off";
    case F::Home:
      return "home";
    case F::LowerToLayer:
      return "lower to layer";
    case F::WaitToSettle:
      return "wait to settle";
    case F::ShowMask:
      return "show mask";
    case F::LightOn:
      return "light on";
    case F::TimeExposure:
      return "time exposure";
    case F::ShowBlack:
      return "show black";
    case F::AwaitDark:
      return "await dark";
    case F::RecordLayer:
      return "record layer";
    case F::WaitToRest:
      return "wait to rest";
    case F::Lift:
      return "lift";
    case F::NextLayer:
      return "next layer";
    case F::RaiseForALook:
      return "raise for a look";
    case F::Park:
      return "park";
    case F::Finish:
      return "finish";
  }
  return "?";
}

std::string draw_print_states() {
  std::string graph =
      "digraph print {\n  node [shape=box, style=rounded];\n  \"any state\" [style=dashed];\n";
  bool failure_drawn = false;
  for (const PrintTransition& t : kTable) {
    if (t.on == E::Failed && failure_drawn) continue;
    failure_drawn = failure_drawn || t.on == E::Failed;
    std::string label(name_of(t.on));
    for (const PrintEffect effect : t.done())
      label += fmt::format("\\n{}", name_of(effect));
    graph += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"];\n",
                         t.on == E::Failed ? "any state" : name_of(t.from), name_of(t.to), label);
  }
  graph += draw_table("by hand", manual_transitions());
  graph += draw_table("homing", homing_transitions());
  graph += draw_table("projector power", projector_power_transitions());
  graph += draw_table("projector light", projector_light_transitions());
  return graph + "}\n";
}

}  // namespace contourd
