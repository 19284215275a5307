#include "hw/serial/projector_power_states.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct ProjectorPowerTable : testing::StateTableFixture<ProjectorPowerTransition, projector_power_table> {
  // True if a power on is pending in this state.
  static bool is_wanted(S state) {
    const std::set<S> at_rest{S::Unknown,         S::LeftOn,     S::Off,       S::On,
                              S::WarmingUpUnused, S::TurningOff, S::OffOverdue};
    return !at_rest.contains(state);
  }
};

}  // namespace

TEST_CASE_METHOD(ProjectorPowerTable,
                 "Every row of a projector's power leads where it should, with the effects it should have") {
  check_lines(R"(
power on wanted -> asking: ask whether on (unknown, left on, turning off, off overdue)
power off wanted -> turning off: light off, send power off (unknown, left on, asking, on asking, cooling
    down, switching on, warming up, asking ready, still off, unready, on warming up, darkening, sets
    brightness, on, warming up unused)
left on suspected -> left on: ask whether left on (unknown)
power off confirmed -> off: note off (unknown, turning off, off overdue)
left on suspected -> stay: ask whether left on (left on)
says on -> turning off: light off, send power off (left on)
says off -> unknown (left on)
says unclear -> unknown (left on)
says nothing -> stay: ask left on later (left on)
not on yet -> stay: ask left on soon (left on)
line lost -> unknown (left on)
pause over -> stay: ask whether left on (left on)
power on wanted -> off asking: ask whether on (off)
power off wanted -> stay: light off (off, turning off, off overdue)
dropped -> unknown (asking, cooling down, switching on, asking ready, still off, unready, on warming up)
says on -> darkening: watch over, make dark (asking, off asking, on asking, asking ready)
says on early -> on warming up: wait until warm (asking, off asking, on asking)
says off -> cooling down: wait until cool (asking, on asking)
says unclear -> cooling down: wait until cool (asking, on asking)
says nothing -> cooling down: wait until cool (asking, on asking)
power off confirmed -> off asking: note off (asking)
dropped -> off (off asking, off cooling down)
power off wanted -> off: light off (off asking, off cooling down)
says off -> off cooling down: wait until cool (off asking)
says unclear -> off cooling down: wait until cool (off asking)
says nothing -> off cooling down: wait until cool (off asking)
dropped -> on (on asking, darkening, sets brightness)
went off -> asking: report went off (on asking)
cool -> switching on: send power on (cooling down, off cooling down)
power off confirmed -> off cooling down: note off, wait until cool (cooling down)
power on answered -> warming up: wait until warm, suspect light (switching on)
power on failed -> unknown: tell (switching on)
power off confirmed -> off cooling down: drop power on, note off, wait until cool (switching on)
dropped -> warming up unused: wait until warm (warming up)
warm -> asking ready: ask whether ready (warming up)
says off -> still off: pause (asking ready)
says unclear -> unready: pause (asking ready)
says nothing -> unknown: tell (asking ready)
never on -> unknown: tell never on (asking ready)
pause over -> switching on: send power on (still off)
pause over -> asking ready: ask whether ready (unready)
warm -> darkening: watch over, make dark (on warming up)
light is off -> sets brightness: set brightness (darkening)
light off failed -> on: tell (darkening)
went off -> unknown: report went off, tell went off (darkening, sets brightness)
brightness answered -> on: tell (sets brightness)
power on wanted -> on asking: ask whether still on (on)
went off -> unknown: report went off (on)
power on wanted -> warming up: wait until warm (warming up unused)
warm -> unknown (warming up unused)
pause over -> stay: send power off (turning off, off overdue)
power off unanswered -> stay: power off again, ask whether off (turning off)
power off late -> off overdue: report lamp on, power off again later, ask whether off (turning off)
power off unknowable -> unknown (turning off, off overdue)
power off unanswered -> stay: power off again later, ask whether off (off overdue)
power off late -> stay: power off again later, ask whether off (off overdue)
)");
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "The table of a projector's power reaches every state, and turns the light off first") {
  check_structure();
}

TEST_CASE_METHOD(
    ProjectorPowerTable,
    "A power off that is wanted turns the light off first, in every state, and ends a pending power on") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const Transition* found = find(state, E::PowerOffWanted);
    REQUIRE(found != nullptr);
    CHECK(found->effects.front() == F::LightOff);
    CHECK((is_turned_off(found->to) || found->to == S::Off));
    CHECK((found->to == S::Off) == is_off(state));
  }
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "Power off is sent until it is confirmed, no longer wanted or cannot be known") {
  const std::set<E> ends{E::PowerOffConfirmed, E::PowerOffUnknowable, E::PowerOnWanted};
  for (const Transition& t : transitions()) {
    if (!is_turned_off(t.from)) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(is_turned_off(t.to) != ends.contains(t.on));
    const bool unanswered = t.on == E::PowerOffUnanswered || t.on == E::PowerOffLate;
    CHECK(unanswered == (has(t, F::PowerOffAgain) || has(t, F::PowerOffAgainLater)));
  }
}

TEST_CASE_METHOD(
    ProjectorPowerTable,
    "Light off drops a power on in every state in which one waits, and sends nothing of its own") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const Transition* found = find(state, E::Dropped);
    CHECK((found != nullptr) == is_wanted(state));
    if (found == nullptr) continue;
    CHECK_FALSE(is_wanted(found->to));
    CHECK(is_off(found->to) == is_off(state));
    CHECK(is_on(found->to) == is_on(state));
    for (const F effect : found->effects)
      CHECK(effect == F::WaitUntilWarm);
  }
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "Power on is sent only where it is wanted, and its light is suspected from then on") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(has(t, F::SendPowerOn) == (t.to == S::SwitchingOn));
    if (has(t, F::SendPowerOn)) CHECK(is_wanted(t.from));
    CHECK(has(t, F::SuspectLight) == (t.on == E::PowerOnAnswered));
    CHECK(has(t, F::MakeDark) == (t.to == S::Darkening));
    CHECK(has(t, F::SetBrightness) == (t.on == E::LightIsOff));
  }
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "A power on is answered when it succeeds, fails or is undone, unless light off came first") {
  for (const Transition& t : transitions()) {
    if (!is_wanted(t.from) || is_wanted(t.to)) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    const bool answered = has(t, F::Tell) || has(t, F::TellNeverOn) || has(t, F::TellWentOff);
    CHECK(answered == (t.on != E::Dropped && t.on != E::PowerOffWanted));
  }
}

TEST_CASE_METHOD(ProjectorPowerTable, "A projector that goes off by itself is reported wherever it was on") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const Transition* found = find(state, E::WentOff);
    CHECK((found != nullptr) == is_on(state));
    if (found == nullptr) continue;
    CHECK(found->effects.front() == F::ReportWentOff);
    CHECK_FALSE(is_on(found->to));
  }
}
