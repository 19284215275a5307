#include "daemon/print/manual_states.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

using State = ManualState;
using Event = ManualEvent;
using Effect = ManualEffect;

struct ManualRow {
  State from;
  Event on;
  State to;
  std::vector<Effect> effects;
};

const std::vector<Effect> kManualFailure{Effect::LightOff, Effect::BlackNow, Effect::AbortAxis,
                                         Effect::AwaitDark};
const std::vector<Effect> kManualDarkAndWait{Effect::LightOff, Effect::BlackNow, Effect::AwaitDark};
const std::vector<Effect> kManualBrake{Effect::LightOff, Effect::StopAxis};

// The expected rows, written down independently of the table.
const std::vector<ManualRow> kExpectedManualRows{
    {State::Idle, Event::Home, State::Homing, {Effect::Home}},
    {State::Idle, Event::Move, State::Moving, {Effect::Move}},
    {State::Idle, Event::Nudge, State::Moving, {Effect::Nudge}},
    {State::Idle, Event::PowerOn, State::PoweringOn, {Effect::LightOff, Effect::PowerOn}},
    {State::Idle,
     Event::PowerOff,
     State::Extinguishing,
     {Effect::LightOff, Effect::PowerOff, Effect::AwaitDark}},
    {State::Idle, Event::LightOn, State::WarmingUp, {Effect::LightOff, Effect::PowerOn}},
    {State::Idle, Event::AskStatus, State::Asking, {Effect::AskStatus}},
    {State::Homing, Event::Homed, State::Idle, {}},
    {State::Moving, Event::MoveEnded, State::Idle, {}},
    {State::Braking, Event::MoveEnded, State::Idle, {}},
    {State::PoweringOn, Event::ProjectorReady, State::Idle, {}},
    {State::WarmingUp, Event::ProjectorReady, State::Igniting, {Effect::LightOn}},
    {State::Igniting, Event::LightOnSent, State::Lit, {Effect::TimeLight}},
    {State::Lit, Event::TimeOver, State::Extinguishing, {Effect::LightOff, Effect::AwaitDark}},
    {State::Extinguishing, Event::LightIsOff, State::Idle, {}},
    {State::Extinguishing, Event::GaveUp, State::Idle, {Effect::LightOff, Effect::TellLightMayBeOn}},
    {State::Asking, Event::StatusTold, State::Idle, {}},
    {State::Homing, Event::Stop, State::Braking, kManualBrake},
    {State::Moving, Event::Stop, State::Braking, kManualBrake},
    {State::PoweringOn, Event::Stop, State::Extinguishing, kManualDarkAndWait},
    {State::WarmingUp, Event::Stop, State::Extinguishing, kManualDarkAndWait},
    {State::Igniting, Event::Stop, State::Extinguishing, kManualDarkAndWait},
    {State::Lit, Event::Stop, State::Extinguishing, kManualDarkAndWait},
    {State::Asking, Event::Stop, State::Extinguishing, kManualDarkAndWait},
    {State::Homing, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Moving, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Braking, Event::Failed, State::Extinguishing, kManualFailure},
    {State::PoweringOn, Event::Failed, State::Extinguishing, kManualFailure},
    {State::WarmingUp, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Igniting, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Lit, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Asking, Event::Failed, State::Extinguishing, kManualFailure},
    {State::Extinguishing,
     Event::Failed,
     State::Extinguishing,
     {Effect::LightOff, Effect::BlackNow, Effect::AbortAxis}},
};

bool has(const ManualTransition& row, Effect effect) {
  return std::ranges::find(row.done(), effect) != row.done().end();
}

}  // namespace

TEST_CASE("Every row of manual control leads to the expected state with the expected effects") {
  for (const ManualRow& row : kExpectedManualRows) {
    CAPTURE(name_of(row.from), name_of(row.on));
    const ManualTransition* found = find_row(manual_transitions(), row.from, row.on);
    REQUIRE(found != nullptr);
    CHECK(found->to == row.to);
    CHECK(std::vector<Effect>(found->done().begin(), found->done().end()) == row.effects);
  }
  CHECK(manual_transitions().size() == kExpectedManualRows.size());
}

TEST_CASE("In manual control, no state has two rows for one event") {
  std::set<std::pair<State, Event>> seen;
  for (const ManualTransition& row : manual_transitions())
    CHECK(seen.insert({row.from, row.on}).second);
}

TEST_CASE("In manual control, light off always comes first, and every row that leaves a lit state has it") {
  for (const ManualTransition& row : manual_transitions()) {
    CAPTURE(name_of(row.from), name_of(row.on));
    if (has(row, Effect::LightOff)) CHECK(row.done().front() == Effect::LightOff);
    const bool lit = row.from == State::Igniting || row.from == State::Lit;
    if (lit && row.to != State::Lit) CHECK(has(row, Effect::LightOff));
  }
}

TEST_CASE(
    "In manual control, every active state can be stopped and can fail, and the light's end is awaited") {
  for (const ManualTransition& row : manual_transitions()) {
    if (row.to == State::Idle || row.to == State::Extinguishing || row.to == State::Braking) continue;
    CAPTURE(name_of(row.to));
    CHECK(find_row(manual_transitions(), row.to, Event::Stop) != nullptr);
    CHECK(find_row(manual_transitions(), row.to, Event::Failed) != nullptr);
  }
  for (const ManualTransition& row : manual_transitions()) {
    if (row.to == State::Extinguishing && row.from != State::Extinguishing)
      CHECK(has(row, Effect::AwaitDark));
  }
}

TEST_CASE("In manual control, nothing moves while there may be light") {
  for (const ManualTransition& row : manual_transitions()) {
    if (!has(row, Effect::Home) && !has(row, Effect::Move) && !has(row, Effect::Nudge)) continue;
    CHECK(row.from == State::Idle);
    CHECK_FALSE(has(row, Effect::LightOn));
  }
}
