#include "hw/gpio/homing_states.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct HomingTable : testing::StateTableFixture<HomingTransition, homing_table> {
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
  check_lines(R"(
home wanted -> getting ready: forget position, get ready (idle)
switch open -> fast pass: seek fast (getting ready)
switch closed -> backing off: back off (getting ready)
stop wanted -> stopping: stop motor (getting ready, backing off, backed off, at switch, approaching)
failed -> idle: tell failed (getting ready, fast pass, fast pass over, backing off, backed off, slow pass,
    slow pass over, at switch, approaching, pass stopping, stopping)
aborted -> idle: drop answer (getting ready, fast pass, fast pass over, backing off, backed off, slow pass,
    slow pass over, at switch, approaching, pass stopping, stopping)
contact -> backing off: back off (fast pass, fast pass over)
spike -> stay: seek on (fast pass, slow pass)
way over -> fast pass over: await contact (fast pass)
stop wanted -> pass stopping: stop motor (fast pass, fast pass over, slow pass, slow pass over)
spike -> fast pass: seek on (fast pass over)
wait over -> idle: tell no trigger (fast pass over, slow pass over)
way over -> backed off: look at switch (backing off)
switch open -> slow pass: seek slow (backed off)
switch closed -> idle: tell still closed (backed off)
contact -> at switch: take position, await rest (slow pass, slow pass over)
way over -> slow pass over: await contact (slow pass)
spike -> slow pass: seek on (slow pass over)
wait over -> approaching: know position, approach (at switch)
arrived -> idle: tell homed (approaching)
contact -> idle: tell stopped (pass stopping)
spike -> idle: tell stopped (pass stopping)
stop wanted -> stay: stop motor (pass stopping, stopping)
stopped -> idle: tell stopped (pass stopping, stopping)
)");
}

TEST_CASE_METHOD(
    HomingTable,
    "The homing table reaches every state, and every state answers a fault, a stop and an abort") {
  check_structure();
}

TEST_CASE_METHOD(HomingTable, "A fault, a stop and an abort end homing") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const Transition *failed = find(state, E::Failed), *aborted = find(state, E::Aborted),
                     *stop = find(state, E::StopWanted);
    if (state == S::Idle) continue;
    CHECK(failed->to == S::Idle);
    CHECK(aborted->to == S::Idle);
    const Transition* stopped = find(stop->to, E::Stopped);
    REQUIRE(stopped != nullptr);
    CHECK(stopped->to == S::Idle);
  }
}

TEST_CASE_METHOD(HomingTable, "Homing answers once, when it ends, unless it is aborted") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    const auto answers = std::ranges::count_if(t.effects, tells);
    CHECK(answers == (t.to == S::Idle && t.on != E::Aborted ? 1 : 0));
    CHECK(has(t, F::DropAnswer) == (t.on == E::Aborted));
    // The callback may home again, so no effect may follow the answer.
    if (answers > 0) CHECK(tells(t.effects.back()));
  }
}

TEST_CASE_METHOD(HomingTable, "After a stop request no effect turns the motor") {
  for (const Transition& t : transitions()) {
    if (t.from != S::PassStopping && t.from != S::Stopping) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK((t.to == t.from || t.to == S::Idle));
    CHECK(std::ranges::none_of(t.effects, turns_motor));
  }
}

TEST_CASE_METHOD(
    HomingTable,
    "The position is taken only from the slow pass' contact, and known before the plate moves by it") {
  for (const Transition& t : transitions()) {
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
    const Transition *contact = find(state, E::Contact), *spike = find(state, E::Spike);
    CHECK((contact != nullptr) == is_in_pass(state));
    CHECK((spike != nullptr) == is_in_pass(state));
    if (spike == nullptr || state == S::PassStopping) continue;
    CHECK(is_in_pass(spike->to));
    CHECK(has(*spike, F::SeekOn));
  }
}
