#include "hw/serial/projector_light_states.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct ProjectorLightTable : testing::StateTableFixture<ProjectorLightTransition, projector_light_table> {};

}  // namespace

TEST_CASE_METHOD(ProjectorLightTable,
                 "Every row of a projector's light leads where it should, with the effects it should have") {
  check_lines(R"(
light on sent -> turning on: note light on (dark, lit, coming up, asked whether on, lit asked whether on,
    lost lit)
light on failed -> making sure: send light off, tell unlit (dark, asked whether on)
power on sent -> coming up (dark)
suspected -> turning off: send light off (dark, lit, coming up, asked whether on, lit asked whether on, lost
    lit)
light off wanted -> making sure: send light off (dark, asked whether on)
says on -> turning off: send light off (dark, asked whether on)
power is off -> stay: stop sending, note dark, tell dark (dark)
light on confirmed -> lit: note lit, tell lit (turning on)
light on ambiguous -> lit: tell lit (turning on)
light on unanswered -> asked whether lit: ask whether lit (turning on)
light on failed -> turning off: send light off, tell unlit (turning on)
suspected -> turning off: send light off, tell unlit (turning on, asked whether lit)
light off wanted -> turning off: send light off (turning on, asked whether lit, lit, coming up, lit asked
    whether on, lost lit)
power is off -> dark: stop sending, note dark, tell dark (turning on, asked whether lit, lit, coming up,
    making sure, turning off, asked whether on, lit asked whether on, lost lit)
says lit -> lit: note lit, tell lit (asked whether lit)
says unlit -> turning off: send light off, tell unlit (asked whether lit)
light on sent -> turning off: note light on, send light off, tell unlit (making sure)
power on sent -> turning off: send light off (making sure)
suspected -> turning off: repeat light off (making sure)
light off wanted -> stay: repeat light off (making sure, turning off, overdue)
light off confirmed -> dark: note dark, tell dark, tell confirmed (making sure, turning off)
light off too early -> stay: retry later (making sure, turning off, overdue)
light off unanswered -> asked whether on: tell dark, ask whether on (making sure)
light off refused -> asked whether on: tell dark, ask whether on (making sure)
light off failed -> dark: tell dark, tell unconfirmed (making sure)
light off garbled -> turning off: send light off (making sure)
light off unclear -> turning off: send light off (making sure)
line lost -> dark: tell unconfirmed (making sure)
retry due -> stay: repeat light off (making sure, turning off, overdue)
light on sent -> stay: note light on, send light off, tell unlit (turning off, overdue)
power on sent -> stay: send light off (turning off, overdue)
suspected -> stay: repeat light off (turning off, overdue)
light off unanswered -> overdue: retry later, drop light on, report overdue, tell unconfirmed (turning off)
light off refused -> lit asked whether on: ask whether on (turning off)
light off failed -> overdue: retry later, drop light on, report overdue, tell unconfirmed (turning off)
light off garbled -> overdue: retry later, drop light on, report overdue, tell unconfirmed (turning off)
light off unclear -> stay: send light off (turning off, overdue)
line lost -> lost lit: tell unconfirmed (turning off)
light off confirmed -> dark: note dark, tell dark, report dark, tell confirmed (overdue)
light off unanswered -> stay: retry later, drop light on, tell unconfirmed (overdue)
light off refused -> overdue asked whether on: ask whether on (overdue)
light off failed -> stay: retry later, drop light on, tell unconfirmed (overdue)
light off garbled -> stay: retry later, drop light on, tell unconfirmed (overdue)
line lost -> lost overdue: tell unconfirmed (overdue)
power is off -> dark: stop sending, note dark, tell dark, report dark (overdue, overdue asked whether on,
    lost overdue)
power on sent -> lit asked whether on (asked whether on)
says off -> dark: note dark, tell dark, tell confirmed (asked whether on, lit asked whether on)
says nothing -> dark: tell unconfirmed (asked whether on)
says too early -> making sure: retry later (asked whether on)
says on -> overdue: retry later, drop light on, report overdue, tell unconfirmed (lit asked whether on)
says nothing -> overdue: retry later, drop light on, report overdue, tell unconfirmed (lit asked whether on)
says too early -> turning off: retry later (lit asked whether on)
suspected -> overdue: send light off (overdue asked whether on, lost overdue)
light off wanted -> overdue: send light off (overdue asked whether on, lost overdue)
says off -> dark: note dark, tell dark, report dark, tell confirmed (overdue asked whether on)
says on -> overdue: retry later, drop light on, tell unconfirmed (overdue asked whether on)
says nothing -> overdue: retry later, drop light on, tell unconfirmed (overdue asked whether on)
says too early -> overdue: retry later (overdue asked whether on)
)");
}

TEST_CASE_METHOD(ProjectorLightTable,
                 "The table of a projector's light reaches every state, and no way out leaves the light on") {
  check_structure();
}

TEST_CASE_METHOD(
    ProjectorLightTable,
    "A light off that is wanted is sent in every state, before anything else, until it is confirmed") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const Transition* found = find(state, E::LightOffWanted);
    REQUIRE(found != nullptr);
    CHECK(is_turned_off(found->to));
    const bool again = is_turned_off(state);
    CHECK(found->effects.front() == (again ? F::RepeatLightOff : F::SendLightOff));
    CHECK((may_shine(found->to) || !may_shine(state)));
  }
}

TEST_CASE_METHOD(ProjectorLightTable, "A light counts as on from the first byte of light on or of power on") {
  for (const S state : all_states()) {
    for (const E sent : {E::LightOnSent, E::PowerOnSent}) {
      CAPTURE(name_of(state), name_of(sent));
      const Transition* found = find(state, sent);
      CHECK(may_shine(found != nullptr ? found->to : state));
    }
  }
}

TEST_CASE_METHOD(
    ProjectorLightTable,
    "A light off under way is sent again after light on or power on: earlier replies do not count") {
  for (const S state : {S::MakingSure, S::TurningOff, S::Overdue}) {
    for (const E sent : {E::LightOnSent, E::PowerOnSent}) {
      CAPTURE(name_of(state), name_of(sent));
      REQUIRE(find(state, sent) != nullptr);
      CHECK(has(*find(state, sent), F::SendLightOff));
    }
  }
}

TEST_CASE_METHOD(
    ProjectorLightTable,
    "A light that may be on is off only when light off is confirmed or the projector says that it is off") {
  const std::set<E> confirmations{E::LightOffConfirmed, E::SaysOff, E::PowerIsOff};
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    if (may_shine(t.from) && !may_shine(t.to)) CHECK(confirmations.contains(t.on));
    CHECK(has(t, F::NoteDark) == confirmations.contains(t.on));
    if (has(t, F::TellConfirmed)) CHECK(t.to == S::Dark);
  }
}

TEST_CASE_METHOD(
    ProjectorLightTable,
    "A light on that is not confirmed leads to a question or to light off, and is never sent again") {
  for (const E unconfirmed : {E::LightOnUnanswered, E::LightOnFailed}) {
    const Transition* found = find(S::TurningOn, unconfirmed);
    REQUIRE(found != nullptr);
    CHECK((found->effects.front() == F::AskWhetherLit || found->effects.front() == F::SendLightOff));
  }
  CHECK(find(S::AskedWhetherLit, E::SaysUnlit)->effects.front() == F::SendLightOff);
  // No effect sends light on: only ProjectorLight::turn_on() does.
  for (const Transition& t : transitions())
    if (has(t, F::TellLit)) CHECK(t.to == S::Lit);
}

TEST_CASE_METHOD(ProjectorLightTable,
                 "A light off under way ends with an answer to it, or goes on after a pause") {
  for (const S state : {S::MakingSure, S::TurningOff, S::Overdue}) {
    for (const E answer : {E::LightOffConfirmed, E::LightOffTooEarly, E::LightOffUnanswered,
                           E::LightOffRefused, E::LightOffFailed, E::LightOffGarbled, E::LightOffUnclear}) {
      CAPTURE(name_of(state), name_of(answer));
      const Transition* found = find(state, answer);
      REQUIRE(found != nullptr);
      const bool goes_on = has(*found, F::RetryLater) || has(*found, F::SendLightOff);
      CHECK(is_turned_off(found->to) == goes_on);
      CHECK((found->to == S::Dark || goes_on || has(*found, F::AskWhetherOn)));
    }
    CHECK(find(state, E::RetryDue)->effects.front() == F::RepeatLightOff);
  }
}

TEST_CASE_METHOD(ProjectorLightTable,
                 "A light off that is not confirmed is reported once, and so is its confirmation") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(has(t, F::ReportOverdue) == (!is_overdue(t.from) && is_overdue(t.to)));
    CHECK(has(t, F::ReportDark) == (is_overdue(t.from) && t.to == S::Dark));
    if (is_overdue(t.from)) CHECK((is_overdue(t.to) || t.to == S::Dark));
  }
}

TEST_CASE_METHOD(ProjectorLightTable, "A projector without power has no light") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    REQUIRE(find(state, E::PowerIsOff) != nullptr);
    CHECK(find(state, E::PowerIsOff)->to == S::Dark);
  }
}
