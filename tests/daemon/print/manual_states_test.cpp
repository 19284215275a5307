#include "daemon/print/manual_states.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

using S = ManualState;
using E = ManualEvent;
using F = ManualEffect;

struct Row {
  S from;
  E on;
  S to;
  std::vector<F> effects;
};

const std::vector<F> kFailure{F::LightOff, F::BlackNow, F::AbortAxis, F::AwaitDark};
const std::vector<F> kDarkAndWait{F::LightOff, F::BlackNow, F::AwaitDark};
const std::vector<F> kBrake{F::LightOff, F::StopAxis};

// Written out apart from the table, row for row.
const std::vector<Row> kExpected{
    {S::Idle, E::Home, S::Homing, {F::Home}},
    {S::Idle, E::Move, S::Moving, {F::Move}},
    {S::Idle, E::Nudge, S::Moving, {F::Nudge}},
    {S::Idle, E::PowerOn, S::PoweringOn, {F::LightOff, F::PowerOn}},
    {S::Idle, E::PowerOff, S::Extinguishing, {F::LightOff, F::PowerOff, F::AwaitDark}},
    {S::Idle, E::LightOn, S::WarmingUp, {F::LightOff, F::PowerOn}},
    {S::Idle, E::AskStatus, S::Asking, {F::AskStatus}},
    {S::Homing, E::Homed, S::Idle, {}},
    {S::Moving, E::MoveEnded, S::Idle, {}},
    {S::Braking, E::MoveEnded, S::Idle, {}},
    {S::PoweringOn, E::ProjectorReady, S::Idle, {}},
    {S::WarmingUp, E::ProjectorReady, S::Igniting, {F::LightOn}},
    {S::Igniting, E::LightOnSent, S::Lit, {F::TimeLight}},
    {S::Lit, E::TimeOver, S::Extinguishing, {F::LightOff, F::AwaitDark}},
    {S::Extinguishing, E::LightIsOff, S::Idle, {}},
    {S::Extinguishing, E::GaveUp, S::Idle, {F::LightOff, F::TellLightMayBeOn}},
    {S::Asking, E::StatusTold, S::Idle, {}},
    {S::Homing, E::Stop, S::Braking, kBrake},
    {S::Moving, E::Stop, S::Braking, kBrake},
    {S::PoweringOn, E::Stop, S::Extinguishing, kDarkAndWait},
    {S::WarmingUp, E::Stop, S::Extinguishing, kDarkAndWait},
    {S::Igniting, E::Stop, S::Extinguishing, kDarkAndWait},
    {S::Lit, E::Stop, S::Extinguishing, kDarkAndWait},
    {S::Asking, E::Stop, S::Extinguishing, kDarkAndWait},
    {S::Homing, E::Failed, S::Extinguishing, kFailure},
    {S::Moving, E::Failed, S::Extinguishing, kFailure},
    {S::Braking, E::Failed, S::Extinguishing, kFailure},
    {S::PoweringOn, E::Failed, S::Extinguishing, kFailure},
    {S::WarmingUp, E::Failed, S::Extinguishing, kFailure},
    {S::Igniting, E::Failed, S::Extinguishing, kFailure},
    {S::Lit, E::Failed, S::Extinguishing, kFailure},
    {S::Asking, E::Failed, S::Extinguishing, kFailure},
    {S::Extinguishing, E::Failed, S::Extinguishing, {F::LightOff, F::BlackNow, F::AbortAxis}},
};

bool has(const ManualTransition& row, F effect) {
  return std::ranges::find(row.done(), effect) != row.done().end();
}

}  // namespace

TEST_CASE("Every row of what is done by hand leads where it should, with the effects it should have") {
  for (const Row& row : kExpected) {
    CAPTURE(name_of(row.from), name_of(row.on));
    const ManualTransition* found = find_row(manual_transitions(), row.from, row.on);
    REQUIRE(found != nullptr);
    CHECK(found->to == row.to);
    CHECK(std::vector<F>(found->done().begin(), found->done().end()) == row.effects);
  }
  CHECK(manual_transitions().size() == kExpected.size());
}

TEST_CASE("By hand, no state has two rows for one event") {
  std::set<std::pair<S, E>> seen;
  for (const ManualTransition& row : manual_transitions())
    CHECK(seen.insert({row.from, row.on}).second);
}

TEST_CASE("By hand, light off comes first wherever it comes at all, and on every way out of the light") {
  for (const ManualTransition& row : manual_transitions()) {
    CAPTURE(name_of(row.from), name_of(row.on));
    if (has(row, F::LightOff)) CHECK(row.done().front() == F::LightOff);
    const bool lit = row.from == S::Igniting || row.from == S::Lit;
    if (lit && row.to != S::Lit) CHECK(has(row, F::LightOff));
  }
}

TEST_CASE("By hand, every state but the last can be stopped and fails, and the light's end is waited for") {
  for (const ManualTransition& row : manual_transitions()) {
    if (row.to == S::Idle || row.to == S::Extinguishing || row.to == S::Braking) continue;
    CAPTURE(name_of(row.to));
    CHECK(find_row(manual_transitions(), row.to, E::Stop) != nullptr);
    CHECK(find_row(manual_transitions(), row.to, E::Failed) != nullptr);
  }
  for (const ManualTransition& row : manual_transitions()) {
    if (row.to == S::Extinguishing && row.from != S::Extinguishing) CHECK(has(row, F::AwaitDark));
  }
}

TEST_CASE("By hand, nothing moves where there may be light") {
  for (const ManualTransition& row : manual_transitions()) {
    if (!has(row, F::Home) && !has(row, F::Move) && !has(row, F::Nudge)) continue;
    CHECK(row.from == S::Idle);
    CHECK_FALSE(has(row, F::LightOn));
  }
}
