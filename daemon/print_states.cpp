#include "daemon/print_states.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace contourd {
namespace {

using S = PrintState;
using E = PrintEvent;
using F = PrintEffect;

template <typename... Effects>
constexpr PrintTransition row(S from, E on, S to, Effects... effects) {
  static_assert(sizeof...(effects) <= PrintTransition::kMostEffects);
  return {from, on, to, {effects...}, sizeof...(effects)};
}

// Light off before anything that can fail; the motor still; the lamp may rest. The job's files are dealt with
// last.
constexpr PrintTransition failure(S from) {
  return row(from, E::Failed, S::Idle, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::Finish);
}

// Cancelled where nothing moves: the plate goes up, so that the part can be taken.
constexpr PrintTransition cancel_at_rest(S from) {
  return row(from, E::Canceled, S::Parking, F::LightOff, F::BlackNow, F::Park);
}

constexpr PrintTransition cancel_moving(S from) {
  return row(from, E::Canceled, S::Halting, F::LightOff, F::BlackNow, F::StopAxis);
}

// Interrupted at a layer: the plate is peeled off and goes up, so that one can look; the layer is not
// forgotten.
constexpr PrintTransition interruption_at_rest(S from) {
  return row(from, E::Interrupted, S::Lifting, F::LightOff, F::BlackNow, F::Lift);
}

// Interrupted where nothing more need be done than what is under way.
constexpr PrintTransition interruption_unmoved(S in) {
  return row(in, E::Interrupted, in, F::LightOff, F::BlackNow);
}

constexpr auto kTable = std::to_array<PrintTransition>({
    row(S::Idle, E::Started, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn),
    row(S::WarmingUp, E::ProjectorReady, S::Homing, F::Home),
    row(S::Homing, E::Homed, S::Lowering, F::LowerToLayer),

    row(S::Lowering, E::MoveEnded, S::Settling, F::WaitToSettle),
    row(S::Settling, E::WaitOver, S::Showing, F::ShowMask),
    row(S::Showing, E::MaskShown, S::Igniting, F::LightOn),
    row(S::Igniting, E::LightIsOn, S::Exposing, F::TimeExposure),
    row(S::Exposing, E::WaitOver, S::Darkening, F::LightOff, F::ShowBlack),
    row(S::Darkening, E::ScreenBlack, S::Resting, F::RecordLayer, F::WaitToRest),
    row(S::Resting, E::WaitOver, S::Lifting, F::Lift),
    row(S::Lifting, E::LayerDue, S::Lowering, F::NextLayer, F::LowerToLayer),

    row(S::Lifting, E::PauseDue, S::Raising, F::RaiseForALook),
    row(S::Raising, E::MoveEnded, S::Paused),
    row(S::Paused, E::LayerDue, S::Lowering, F::NextLayer, F::LowerToLayer),

    row(S::Lifting, E::LayerUnfinished, S::Lowering, F::LowerToLayer),
    row(S::Paused, E::LayerUnfinished, S::Lowering, F::LowerToLayer),

    row(S::Lifting, E::LayersDone, S::Parking, F::Park),
    row(S::Paused, E::LayersDone, S::Parking, F::Park),
    row(S::Parking, E::MoveEnded, S::Idle, F::LightOff, F::PowerOff, F::Finish),

    // Before the first layer there is nothing to peel off, and while homing no height to go to.
    row(S::WarmingUp, E::Interrupted, S::Held, F::LightOff, F::BlackNow),
    row(S::Homing, E::Interrupted, S::Held, F::LightOff, F::BlackNow, F::AbortAxis),
    row(S::Held, E::Resumed, S::WarmingUp, F::LightOff, F::BlackNow, F::PowerOn),
    row(S::Lowering, E::Interrupted, S::Braking, F::LightOff, F::BlackNow, F::StopAxis),
    row(S::Braking, E::MoveEnded, S::Lifting, F::Lift),
    interruption_at_rest(S::Settling),
    interruption_at_rest(S::Showing),
    interruption_at_rest(S::Igniting),
    interruption_at_rest(S::Exposing),
    // The layer has had its light.
    row(S::Darkening, E::Interrupted, S::Lifting, F::LightOff, F::BlackNow, F::RecordLayer, F::Lift),
    interruption_at_rest(S::Resting),
    interruption_unmoved(S::Lifting),
    interruption_unmoved(S::Raising),
    interruption_unmoved(S::Paused),
    interruption_unmoved(S::Held),
    interruption_unmoved(S::Braking),
    interruption_unmoved(S::Halting),
    interruption_unmoved(S::Parking),

    // While homing the plate's position is unknown: it can only be left where it is.
    row(S::WarmingUp, E::Canceled, S::Idle, F::LightOff, F::BlackNow, F::PowerOff, F::Finish),
    row(S::Homing, E::Canceled, S::Idle, F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::Finish),
    row(S::Held, E::Canceled, S::Idle, F::LightOff, F::BlackNow, F::PowerOff, F::Finish),
    cancel_moving(S::Lowering),
    cancel_moving(S::Lifting),
    cancel_moving(S::Raising),
    cancel_moving(S::Braking),
    row(S::Halting, E::MoveEnded, S::Parking, F::Park),
    cancel_at_rest(S::Settling),
    cancel_at_rest(S::Showing),
    cancel_at_rest(S::Igniting),
    cancel_at_rest(S::Exposing),
    cancel_at_rest(S::Darkening),
    cancel_at_rest(S::Resting),
    cancel_at_rest(S::Paused),

    failure(S::WarmingUp),
    failure(S::Homing),
    failure(S::Lowering),
    failure(S::Settling),
    failure(S::Showing),
    failure(S::Igniting),
    failure(S::Exposing),
    failure(S::Darkening),
    failure(S::Resting),
    failure(S::Lifting),
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
    case S::Resting:
      return "resting";
    case S::Lifting:
      return "lifting";
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
    case E::LightIsOn:
      return "light is on";
    case E::ScreenBlack:
      return "screen black";
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
  return graph + "}\n";
}

}  // namespace contourd
