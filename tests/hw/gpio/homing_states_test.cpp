#include "hw/gpio/homing_states.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/transition_table_fixture.hpp"

using namespace contourd;

namespace {

struct HomingTable : testing::TransitionTableFixture<HomingTransition, homing_transitions> {
  // The expected table, written out independently, row by row.
  static inline const std::vector<Row> kExpected{
      {S::Idle, E::HomeWanted, S::GettingReady, {F::ForgetPosition, F::GetReady}},
      {S::GettingReady, E::SwitchOpen, S::FastPass, {F::SeekFast}},
      {S::GettingReady, E::SwitchClosed, S::BackingOff, {F::BackOff}},
      {S::FastPass, E::Contact, S::BackingOff, {F::BackOff}},
      {S::FastPass, E::Spike, S::FastPass, {F::SeekOn}},
      {S::FastPass, E::WayOver, S::FastPassOver, {F::AwaitContact}},
      {S::FastPassOver, E::Contact, S::BackingOff, {F::BackOff}},
      {S::FastPassOver, E::Spike, S::FastPass, {F::SeekOn}},
      {S::FastPassOver, E::WaitOver, S::Idle, {F::TellNoTrigger}},
      {S::BackingOff, E::WayOver, S::BackedOff, {F::LookAtSwitch}},
      {S::BackedOff, E::SwitchOpen, S::SlowPass, {F::SeekSlow}},
      {S::BackedOff, E::SwitchClosed, S::Idle, {F::TellStillClosed}},
      {S::SlowPass, E::Contact, S::AtSwitch, {F::TakePosition, F::AwaitRest}},
      {S::SlowPass, E::Spike, S::SlowPass, {F::SeekOn}},
      {S::SlowPass, E::WayOver, S::SlowPassOver, {F::AwaitContact}},
      {S::SlowPassOver, E::Contact, S::AtSwitch, {F::TakePosition, F::AwaitRest}},
      {S::SlowPassOver, E::Spike, S::SlowPass, {F::SeekOn}},
      {S::SlowPassOver, E::WaitOver, S::Idle, {F::TellNoTrigger}},
      {S::AtSwitch, E::WaitOver, S::Approaching, {F::KnowPosition, F::Approach}},
      {S::Approaching, E::Arrived, S::Idle, {F::TellHomed}},
      {S::GettingReady, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::FastPass, E::StopWanted, S::PassStopping, {F::StopMotor}},
      {S::FastPassOver, E::StopWanted, S::PassStopping, {F::StopMotor}},
      {S::BackingOff, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::BackedOff, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::SlowPass, E::StopWanted, S::PassStopping, {F::StopMotor}},
      {S::SlowPassOver, E::StopWanted, S::PassStopping, {F::StopMotor}},
      {S::AtSwitch, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::Approaching, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::PassStopping, E::StopWanted, S::PassStopping, {F::StopMotor}},
      {S::Stopping, E::StopWanted, S::Stopping, {F::StopMotor}},
      {S::PassStopping, E::Contact, S::Idle, {F::TellStopped}},
      {S::PassStopping, E::Spike, S::Idle, {F::TellStopped}},
      {S::PassStopping, E::Stopped, S::Idle, {F::TellStopped}},
      {S::Stopping, E::Stopped, S::Idle, {F::TellStopped}},
      {S::GettingReady, E::Failed, S::Idle, {F::TellFailed}},
      {S::FastPass, E::Failed, S::Idle, {F::TellFailed}},
      {S::FastPassOver, E::Failed, S::Idle, {F::TellFailed}},
      {S::BackingOff, E::Failed, S::Idle, {F::TellFailed}},
      {S::BackedOff, E::Failed, S::Idle, {F::TellFailed}},
      {S::SlowPass, E::Failed, S::Idle, {F::TellFailed}},
      {S::SlowPassOver, E::Failed, S::Idle, {F::TellFailed}},
      {S::AtSwitch, E::Failed, S::Idle, {F::TellFailed}},
      {S::Approaching, E::Failed, S::Idle, {F::TellFailed}},
      {S::PassStopping, E::Failed, S::Idle, {F::TellFailed}},
      {S::Stopping, E::Failed, S::Idle, {F::TellFailed}},
      {S::GettingReady, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::FastPass, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::FastPassOver, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::BackingOff, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::BackedOff, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::SlowPass, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::SlowPassOver, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::AtSwitch, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::Approaching, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::PassStopping, E::Aborted, S::Idle, {F::DropAnswer}},
      {S::Stopping, E::Aborted, S::Idle, {F::DropAnswer}},
  };

  // True for the effects that turn the motor.
  static bool turns_motor(F effect) {
    return effect == F::SeekFast || effect == F::SeekSlow || effect == F::SeekOn || effect == F::BackOff ||
           effect == F::Approach;
  }

  static bool tells(F effect) {
    return effect == F::TellHomed || effect == F::TellNoTrigger || effect == F::TellStillClosed ||
           effect == F::TellStopped || effect == F::TellFailed;
  }
};

}  // namespace

TEST_CASE_METHOD(HomingTable, "The homing table has exactly the rows written here") {
  check_rows(kExpected);
}

TEST_CASE_METHOD(HomingTable, "No state of homing has two rows for the same event") {
  check_one_row_per_event();
}

TEST_CASE_METHOD(HomingTable, "A fault, a stop and an abort end homing in every state") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const HomingTransition *failed = find(state, E::Failed), *aborted = find(state, E::Aborted),
                           *stop = find(state, E::StopWanted);
    CHECK((failed != nullptr) == (state != S::Idle));
    CHECK((aborted != nullptr) == (state != S::Idle));
    CHECK((stop != nullptr) == (state != S::Idle));
    if (state == S::Idle) continue;
    CHECK(failed->to == S::Idle);
    CHECK(aborted->to == S::Idle);
    const HomingTransition* stopped = find(stop->to, E::Stopped);
    REQUIRE(stopped != nullptr);
    CHECK(stopped->to == S::Idle);
  }
}

TEST_CASE_METHOD(HomingTable, "Homing answers once, when it ends, unless it is aborted") {
  for (const HomingTransition& t : homing_transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    const auto answers = std::ranges::count_if(t.done(), tells);
    CHECK(answers == (t.to == S::Idle && t.on != E::Aborted ? 1 : 0));
    CHECK(has(t, F::DropAnswer) == (t.on == E::Aborted));
    // The callback may home again, so no effect may follow the answer.
    if (answers > 0) CHECK(tells(t.done().back()));
  }
}

TEST_CASE_METHOD(HomingTable, "After a stop request no effect turns the motor") {
  for (const HomingTransition& t : homing_transitions()) {
    if (t.from != S::PassStopping && t.from != S::Stopping) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK((t.to == t.from || t.to == S::Idle));
    CHECK(std::ranges::none_of(t.done(), turns_motor));
  }
}

TEST_CASE_METHOD(
    HomingTable,
    "The position is taken only from the slow pass' contact, and known before the plate moves by it") {
  for (const HomingTransition& t : homing_transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    const bool slow = t.from == S::SlowPass || t.from == S::SlowPassOver;
    CHECK(has(t, F::TakePosition) == (slow && t.on == E::Contact));
    CHECK(has(t, F::KnowPosition) == (t.from == S::AtSwitch && t.on == E::WaitOver));
    CHECK(has(t, F::Approach) == has(t, F::KnowPosition));
    CHECK(has(t, F::ForgetPosition) == (t.on == E::HomeWanted));
  }
}

TEST_CASE_METHOD(HomingTable, "A pass continues after a spike, and contacts outside a pass are ignored") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const HomingTransition *contact = find(state, E::Contact), *spike = find(state, E::Spike);
    CHECK((contact != nullptr) == is_in_pass(state));
    CHECK((spike != nullptr) == is_in_pass(state));
    if (spike == nullptr || state == S::PassStopping) continue;
    CHECK(is_in_pass(spike->to));
    CHECK(has(*spike, F::SeekOn));
  }
}

TEST_CASE_METHOD(HomingTable, "Every state of homing is reachable, and all names differ") {
  std::set<S> reached{S::Idle};
  for (std::size_t before = 0; before != reached.size();) {
    before = reached.size();
    for (const HomingTransition& t : homing_transitions())
      if (reached.contains(t.from)) reached.insert(t.to);
  }
  CHECK(reached == all_states());
  std::set<std::string_view> names;
  for (const S state : all_states())
    names.insert(name_of(state));
  CHECK(names.size() == all_states().size());
}
