#include "daemon/print/print_states.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "hw/gpio/homing_states.hpp"
#include "hw/serial/projector_light_states.hpp"
#include "hw/serial/projector_power_states.hpp"
#include "tests/catch.hpp"

using namespace contourd;

namespace {

using S = PrintState;
using E = PrintEvent;
using F = PrintEffect;

struct Row {
  S from;
  E on;
  S to;
  std::vector<F> effects;
};

const std::vector<F> kFailure{F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark};
const std::vector<F> kCancelAtRest{F::LightOff, F::BlackNow, F::Park};
const std::vector<F> kCancelMoving{F::LightOff, F::BlackNow, F::StopAxis};
const std::vector<F> kDark{F::LightOff, F::BlackNow};
const std::vector<F> kDarkAndWait{F::LightOff, F::BlackNow, F::AwaitDark};
const std::vector<F> kDarkAndLift{F::LightOff, F::BlackNow, F::Lift};

// The expected rows, written down independently of the table.
const std::vector<Row> kExpected{
    {S::Idle, E::Started, S::WarmingUp, {F::LightOff, F::BlackNow, F::PowerOn}},
    {S::WarmingUp, E::ProjectorReady, S::Homing, {F::Home}},
    {S::Homing, E::Homed, S::AwaitingDark, {F::AwaitDark}},
    {S::Lowering, E::MoveEnded, S::Settling, {F::WaitToSettle}},
    {S::Settling, E::WaitOver, S::Showing, {F::ShowMask}},
    {S::Showing, E::MaskShown, S::Igniting, {F::LightOn}},
    {S::Igniting, E::LightOnSent, S::Exposing, {F::TimeExposure}},
    {S::Exposing, E::WaitOver, S::Darkening, {F::LightOff, F::ShowBlack}},
    {S::Darkening, E::ScreenBlack, S::Extinguishing, {F::AwaitDark}},
    {S::Extinguishing, E::LightIsOff, S::Resting, {F::RecordLayer, F::WaitToRest}},
    {S::Resting, E::WaitOver, S::Lifting, {F::Lift}},
    {S::Lifting, E::MoveEnded, S::AwaitingDark, {F::AwaitDark}},
    {S::AwaitingDark, E::LayerDue, S::Lowering, {F::RecordLayer, F::NextLayer, F::LowerToLayer}},
    {S::AwaitingDark, E::LayerUnfinished, S::Lowering, {F::LowerToLayer}},
    {S::AwaitingDark, E::PauseDue, S::Raising, {F::RaiseForALook}},
    {S::AwaitingDark, E::LayersDone, S::Parking, {F::RecordLayer, F::Park}},
    {S::Raising, E::MoveEnded, S::Paused, {}},
    {S::Paused, E::Resumed, S::AwaitingDark, {F::AwaitDark}},
    {S::WarmingUp, E::Interrupted, S::Held, kDark},
    {S::Homing, E::Interrupted, S::Held, {F::LightOff, F::BlackNow, F::AbortAxis}},
    {S::Held, E::Resumed, S::WarmingUp, {F::LightOff, F::BlackNow, F::PowerOn}},
    {S::Lowering, E::Interrupted, S::Braking, {F::LightOff, F::BlackNow, F::StopAxis}},
    {S::Braking, E::MoveEnded, S::Lifting, {F::Lift}},
    {S::Settling, E::Interrupted, S::Lifting, kDarkAndLift},
    {S::Showing, E::Interrupted, S::Lifting, kDarkAndLift},
    {S::Igniting, E::Interrupted, S::Interrupting, kDarkAndWait},
    {S::Exposing, E::Interrupted, S::Interrupting, kDarkAndWait},
    {S::Darkening, E::Interrupted, S::Interrupting, {F::LightOff, F::BlackNow, F::RecordLayer, F::AwaitDark}},
    {S::Extinguishing,
     E::Interrupted,
     S::Interrupting,
     {F::LightOff, F::BlackNow, F::RecordLayer, F::AwaitDark}},
    {S::Interrupting, E::Interrupted, S::Interrupting, kDark},
    {S::Interrupting, E::LightIsOff, S::Lifting, {F::Lift}},
    {S::Resting, E::Interrupted, S::Lifting, kDarkAndLift},
    {S::AwaitingDark, E::Interrupted, S::Raising, {F::LightOff, F::BlackNow, F::RaiseForALook}},
    {S::Ending, E::Interrupted, S::Ending, kDark},
    {S::Lifting, E::Interrupted, S::Lifting, kDark},
    {S::Raising, E::Interrupted, S::Raising, kDark},
    {S::Paused, E::Interrupted, S::Paused, kDark},
    {S::Held, E::Interrupted, S::Held, kDark},
    {S::Braking, E::Interrupted, S::Braking, kDark},
    {S::Halting, E::Interrupted, S::Halting, kDark},
    {S::Parking, E::Interrupted, S::Parking, kDark},
    {S::Parking, E::MoveEnded, S::Ending, {F::LightOff, F::PowerOff, F::AwaitDark}},
    {S::Ending, E::LightIsOff, S::Idle, {F::Finish}},
    {S::Ending, E::GaveUp, S::Idle, {F::Finish}},
    {S::WarmingUp, E::Canceled, S::Ending, {F::LightOff, F::BlackNow, F::PowerOff, F::AwaitDark}},
    {S::Homing, E::Canceled, S::Ending, {F::LightOff, F::BlackNow, F::AbortAxis, F::PowerOff, F::AwaitDark}},
    {S::Held, E::Canceled, S::Ending, {F::LightOff, F::BlackNow, F::PowerOff, F::AwaitDark}},
    {S::Braking, E::Canceled, S::Halting, kCancelMoving},
    {S::Lowering, E::Canceled, S::Halting, kCancelMoving},
    {S::Lifting, E::Canceled, S::Halting, kCancelMoving},
    {S::Raising, E::Canceled, S::Halting, kCancelMoving},
    {S::Halting, E::MoveEnded, S::Parking, {F::Park}},
    {S::Settling, E::Canceled, S::Parking, kCancelAtRest},
    {S::Showing, E::Canceled, S::Parking, kCancelAtRest},
    {S::Igniting, E::Canceled, S::Interrupting, kDarkAndWait},
    {S::Exposing, E::Canceled, S::Interrupting, kDarkAndWait},
    {S::Darkening, E::Canceled, S::Interrupting, kDarkAndWait},
    {S::Extinguishing, E::Canceled, S::Interrupting, kDarkAndWait},
    {S::Interrupting, E::Canceled, S::Interrupting, kDark},
    {S::Resting, E::Canceled, S::Parking, kCancelAtRest},
    {S::AwaitingDark, E::Canceled, S::Parking, kCancelAtRest},
    {S::Paused, E::Canceled, S::Parking, kCancelAtRest},
    {S::WarmingUp, E::Failed, S::Ending, kFailure},
    {S::Homing, E::Failed, S::Ending, kFailure},
    {S::Lowering, E::Failed, S::Ending, kFailure},
    {S::Settling, E::Failed, S::Ending, kFailure},
    {S::Showing, E::Failed, S::Ending, kFailure},
    {S::Igniting, E::Failed, S::Ending, kFailure},
    {S::Exposing, E::Failed, S::Ending, kFailure},
    {S::Darkening, E::Failed, S::Ending, kFailure},
    {S::Extinguishing, E::Failed, S::Ending, kFailure},
    {S::Interrupting, E::Failed, S::Ending, kFailure},
    {S::Resting, E::Failed, S::Ending, kFailure},
    {S::AwaitingDark, E::Failed, S::Ending, kFailure},
    {S::Lifting, E::Failed, S::Ending, kFailure},
    {S::Raising, E::Failed, S::Ending, kFailure},
    {S::Paused, E::Failed, S::Ending, kFailure},
    {S::Held, E::Failed, S::Ending, kFailure},
    {S::Braking, E::Failed, S::Ending, kFailure},
    {S::Halting, E::Failed, S::Ending, kFailure},
    {S::Parking, E::Failed, S::Ending, kFailure},
};

std::set<S> all_states() {
  std::set<S> states;
  for (const PrintTransition& t : print_transitions())
    states.insert({t.from, t.to});
  return states;
}

}  // namespace

TEST_CASE("Every row of the print process leads to the expected state with the expected effects") {
  for (const Row& row : kExpected) {
    CAPTURE(name_of(row.from), name_of(row.on));
    const PrintTransition* found = find_transition(row.from, row.on);
    REQUIRE(found != nullptr);
    CHECK(found->to == row.to);
    CHECK(std::vector<F>(found->done().begin(), found->done().end()) == row.effects);
  }
  CHECK(print_transitions().size() == kExpected.size());
}

TEST_CASE("No state has two rows for one event") {
  std::set<std::pair<S, E>> seen;
  for (const PrintTransition& t : print_transitions())
    CHECK(seen.insert({t.from, t.on}).second);
}

TEST_CASE("Every way out of a state in which the light may be on turns it off before anything else") {
  for (const S lit : {S::Igniting, S::Exposing}) {
    for (const PrintTransition& t : print_transitions()) {
      if (t.from != lit || t.to == S::Exposing) continue;
      CAPTURE(name_of(t.from), name_of(t.on));
      CHECK(t.done().front() == F::LightOff);
    }
  }
}

TEST_CASE("Light off is always the first effect of its row") {
  for (const PrintTransition& t : print_transitions()) {
    const auto effects = t.done();
    const auto light_off = std::find(effects.begin(), effects.end(), F::LightOff);
    CHECK((light_off == effects.end() || light_off == effects.begin()));
  }
}

TEST_CASE("A print can fail in every state before its end, and becomes idle only by finishing") {
  for (const S state : all_states()) {
    if (state == S::Idle || state == S::Ending) continue;
    CAPTURE(name_of(state));
    REQUIRE(find_transition(state, E::Failed) != nullptr);
    CHECK(find_transition(state, E::Failed)->to == S::Ending);
  }
  for (const PrintTransition& t : print_transitions()) {
    CHECK((t.to == S::Idle) == (t.effect_count > 0 && t.done().back() == F::Finish));
  }
}

TEST_CASE(
    "An interruption is possible in every state of a print, turns the light off and never ends the print") {
  for (const S state : all_states()) {
    if (state == S::Idle) continue;
    CAPTURE(name_of(state));
    const PrintTransition* found = find_transition(state, E::Interrupted);
    REQUIRE(found != nullptr);
    CHECK(found->done().front() == F::LightOff);
    CHECK(found->to != S::Idle);
  }
}

TEST_CASE("The light goes on only when the mask is on the screen") {
  for (const PrintTransition& t : print_transitions()) {
    const auto effects = t.done();
    const bool ignites = std::find(effects.begin(), effects.end(), F::LightOn) != effects.end();
    CHECK(ignites == (t.from == S::Showing && t.on == E::MaskShown));
  }
}

TEST_CASE("The plate moves down into the resin, and a mask is shown, only after the light is confirmed off") {
  for (const PrintTransition& t : print_transitions()) {
    const auto effects = t.done();
    const auto has = [&](F effect) {
      return std::find(effects.begin(), effects.end(), effect) != effects.end();
    };
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(has(F::LowerToLayer) == (t.to == S::Lowering));
    if (t.to == S::Lowering) CHECK(t.from == S::AwaitingDark);
    if (has(F::ShowMask)) CHECK(t.from == S::Settling);
    if (t.to == S::Settling) CHECK(t.from == S::Lowering);
    // A state that waits for the light to be confirmed off is entered with AwaitDark.
    const bool waits =
        t.to == S::AwaitingDark || t.to == S::Extinguishing || t.to == S::Interrupting || t.to == S::Ending;
    if (waits) CHECK((has(F::AwaitDark) || t.from == t.to));
  }
}

TEST_CASE("Nothing moves while there may be light") {
  const std::set<S> lit{S::Igniting, S::Exposing, S::Darkening, S::Extinguishing, S::Interrupting};
  for (const PrintTransition& t : print_transitions()) {
    if (!lit.contains(t.from)) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    for (const F effect : t.done())
      if (effect == F::Lift || effect == F::Park || effect == F::RaiseForALook) CHECK(t.on == E::LightIsOff);
  }
}

TEST_CASE("The drawing names every state, including homing and a projector's power and light") {
  const std::string drawing = draw_print_states();
  for (const S state : all_states())
    CHECK(drawing.find("\"" + std::string(name_of(state)) + "\"") != std::string::npos);
  for (const HomingTransition& t : homing_transitions())
    CHECK(drawing.find("\"homing: " + std::string(name_of(t.to)) + "\"") != std::string::npos);
  for (const ProjectorPowerTransition& t : projector_power_transitions())
    CHECK(drawing.find("\"projector power: " + std::string(name_of(t.to)) + "\"") != std::string::npos);
  for (const ProjectorLightTransition& t : projector_light_transitions())
    CHECK(drawing.find("\"projector light: " + std::string(name_of(t.to)) + "\"") != std::string::npos);
}
