#include "hw/serial/projector_light_states.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/transition_table_fixture.hpp"

using namespace contourd;

namespace {

struct ProjectorLightTable
    : testing::TransitionTableFixture<ProjectorLightTransition, projector_light_transitions> {
  // The expected table, written out separately, row for row.
  static inline const std::vector<Row> kExpected{
      {S::Dark, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::AskedWhetherOn, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::Lit, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::ComingUp, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::LitAskedWhetherOn, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::LostLit, E::LightOnSent, S::TurningOn, {F::NoteLightOn}},
      {S::MakingSure, E::LightOnSent, S::TurningOff, {F::NoteLightOn, F::SendLightOff, F::TellUnlit}},
      {S::TurningOff, E::LightOnSent, S::TurningOff, {F::NoteLightOn, F::SendLightOff, F::TellUnlit}},
      {S::Overdue, E::LightOnSent, S::Overdue, {F::NoteLightOn, F::SendLightOff, F::TellUnlit}},
      {S::TurningOn, E::LightOnConfirmed, S::Lit, {F::NoteLit, F::TellLit}},
      {S::TurningOn, E::LightOnAmbiguous, S::Lit, {F::TellLit}},
      {S::TurningOn, E::LightOnUnanswered, S::AskedWhetherLit, {F::AskWhetherLit}},
      {S::TurningOn, E::LightOnFailed, S::TurningOff, {F::SendLightOff, F::TellUnlit}},
      {S::AskedWhetherLit, E::SaysLit, S::Lit, {F::NoteLit, F::TellLit}},
      {S::AskedWhetherLit, E::SaysUnlit, S::TurningOff, {F::SendLightOff, F::TellUnlit}},
      {S::Dark, E::LightOnFailed, S::MakingSure, {F::SendLightOff, F::TellUnlit}},
      {S::AskedWhetherOn, E::LightOnFailed, S::MakingSure, {F::SendLightOff, F::TellUnlit}},
      {S::Dark, E::PowerOnSent, S::ComingUp, {}},
      {S::AskedWhetherOn, E::PowerOnSent, S::LitAskedWhetherOn, {}},
      {S::MakingSure, E::PowerOnSent, S::TurningOff, {F::SendLightOff}},
      {S::TurningOff, E::PowerOnSent, S::TurningOff, {F::SendLightOff}},
      {S::Overdue, E::PowerOnSent, S::Overdue, {F::SendLightOff}},
      {S::Dark, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::TurningOn, E::Suspected, S::TurningOff, {F::SendLightOff, F::TellUnlit}},
      {S::AskedWhetherLit, E::Suspected, S::TurningOff, {F::SendLightOff, F::TellUnlit}},
      {S::Lit, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::ComingUp, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::AskedWhetherOn, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::LitAskedWhetherOn, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::LostLit, E::Suspected, S::TurningOff, {F::SendLightOff}},
      {S::MakingSure, E::Suspected, S::TurningOff, {F::RepeatLightOff}},
      {S::TurningOff, E::Suspected, S::TurningOff, {F::RepeatLightOff}},
      {S::Overdue, E::Suspected, S::Overdue, {F::RepeatLightOff}},
      {S::OverdueAskedWhetherOn, E::Suspected, S::Overdue, {F::SendLightOff}},
      {S::LostOverdue, E::Suspected, S::Overdue, {F::SendLightOff}},
      {S::Dark, E::LightOffWanted, S::MakingSure, {F::SendLightOff}},
      {S::AskedWhetherOn, E::LightOffWanted, S::MakingSure, {F::SendLightOff}},
      {S::TurningOn, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::AskedWhetherLit, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::Lit, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::ComingUp, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::LitAskedWhetherOn, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::LostLit, E::LightOffWanted, S::TurningOff, {F::SendLightOff}},
      {S::OverdueAskedWhetherOn, E::LightOffWanted, S::Overdue, {F::SendLightOff}},
      {S::LostOverdue, E::LightOffWanted, S::Overdue, {F::SendLightOff}},
      {S::MakingSure, E::LightOffWanted, S::MakingSure, {F::RepeatLightOff}},
      {S::TurningOff, E::LightOffWanted, S::TurningOff, {F::RepeatLightOff}},
      {S::Overdue, E::LightOffWanted, S::Overdue, {F::RepeatLightOff}},
      {S::MakingSure, E::RetryDue, S::MakingSure, {F::RepeatLightOff}},
      {S::TurningOff, E::RetryDue, S::TurningOff, {F::RepeatLightOff}},
      {S::Overdue, E::RetryDue, S::Overdue, {F::RepeatLightOff}},
      {S::MakingSure, E::LightOffConfirmed, S::Dark, {F::NoteDark, F::TellDark, F::TellConfirmed}},
      {S::TurningOff, E::LightOffConfirmed, S::Dark, {F::NoteDark, F::TellDark, F::TellConfirmed}},
      {S::Overdue,
       E::LightOffConfirmed,
       S::Dark,
       {F::NoteDark, F::TellDark, F::ReportDark, F::TellConfirmed}},
      {S::MakingSure, E::LightOffTooEarly, S::MakingSure, {F::RetryLater}},
      {S::TurningOff, E::LightOffTooEarly, S::TurningOff, {F::RetryLater}},
      {S::Overdue, E::LightOffTooEarly, S::Overdue, {F::RetryLater}},
      {S::MakingSure, E::LightOffUnanswered, S::AskedWhetherOn, {F::TellDark, F::AskWhetherOn}},
      {S::MakingSure, E::LightOffRefused, S::AskedWhetherOn, {F::TellDark, F::AskWhetherOn}},
      {S::MakingSure, E::LightOffFailed, S::Dark, {F::TellDark, F::TellUnconfirmed}},
      {S::MakingSure, E::LightOffGarbled, S::TurningOff, {F::SendLightOff}},
      {S::MakingSure, E::LightOffUnclear, S::TurningOff, {F::SendLightOff}},
      {S::MakingSure, E::LineLost, S::Dark, {F::TellUnconfirmed}},
      {S::TurningOff,
       E::LightOffUnanswered,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed}},
      {S::TurningOff,
       E::LightOffFailed,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed}},
      {S::TurningOff,
       E::LightOffGarbled,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed}},
      {S::TurningOff, E::LightOffRefused, S::LitAskedWhetherOn, {F::AskWhetherOn}},
      {S::TurningOff, E::LightOffUnclear, S::TurningOff, {F::SendLightOff}},
      {S::TurningOff, E::LineLost, S::LostLit, {F::TellUnconfirmed}},
      {S::Overdue, E::LightOffUnanswered, S::Overdue, {F::RetryLater, F::DropLightOn, F::TellUnconfirmed}},
      {S::Overdue, E::LightOffFailed, S::Overdue, {F::RetryLater, F::DropLightOn, F::TellUnconfirmed}},
      {S::Overdue, E::LightOffGarbled, S::Overdue, {F::RetryLater, F::DropLightOn, F::TellUnconfirmed}},
      {S::Overdue, E::LightOffRefused, S::OverdueAskedWhetherOn, {F::AskWhetherOn}},
      {S::Overdue, E::LightOffUnclear, S::Overdue, {F::SendLightOff}},
      {S::Overdue, E::LineLost, S::LostOverdue, {F::TellUnconfirmed}},
      {S::AskedWhetherOn, E::SaysOff, S::Dark, {F::NoteDark, F::TellDark, F::TellConfirmed}},
      {S::AskedWhetherOn, E::SaysOn, S::TurningOff, {F::SendLightOff}},
      {S::AskedWhetherOn, E::SaysNothing, S::Dark, {F::TellUnconfirmed}},
      {S::AskedWhetherOn, E::SaysTooEarly, S::MakingSure, {F::RetryLater}},
      {S::LitAskedWhetherOn, E::SaysOff, S::Dark, {F::NoteDark, F::TellDark, F::TellConfirmed}},
      {S::LitAskedWhetherOn,
       E::SaysOn,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed}},
      {S::LitAskedWhetherOn,
       E::SaysNothing,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed}},
      {S::LitAskedWhetherOn, E::SaysTooEarly, S::TurningOff, {F::RetryLater}},
      {S::OverdueAskedWhetherOn,
       E::SaysOff,
       S::Dark,
       {F::NoteDark, F::TellDark, F::ReportDark, F::TellConfirmed}},
      {S::OverdueAskedWhetherOn, E::SaysOn, S::Overdue, {F::RetryLater, F::DropLightOn, F::TellUnconfirmed}},
      {S::OverdueAskedWhetherOn,
       E::SaysNothing,
       S::Overdue,
       {F::RetryLater, F::DropLightOn, F::TellUnconfirmed}},
      {S::OverdueAskedWhetherOn, E::SaysTooEarly, S::Overdue, {F::RetryLater}},
      {S::Dark, E::SaysOn, S::TurningOff, {F::SendLightOff}},
      {S::Dark, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::TurningOn, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::AskedWhetherLit, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::Lit, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::ComingUp, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::MakingSure, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::TurningOff, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::AskedWhetherOn, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::LitAskedWhetherOn, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::LostLit, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark}},
      {S::Overdue, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark, F::ReportDark}},
      {S::OverdueAskedWhetherOn,
       E::PowerIsOff,
       S::Dark,
       {F::StopSending, F::NoteDark, F::TellDark, F::ReportDark}},
      {S::LostOverdue, E::PowerIsOff, S::Dark, {F::StopSending, F::NoteDark, F::TellDark, F::ReportDark}},
  };
};

}  // namespace

TEST_CASE_METHOD(ProjectorLightTable,
                 "Every row of a projector's light leads where it should, with the effects it should have") {
  check_rows(kExpected);
}

TEST_CASE_METHOD(ProjectorLightTable, "No state of a projector's light has two rows for one event") {
  check_one_row_per_event();
}

TEST_CASE_METHOD(
    ProjectorLightTable,
    "A light off that is wanted is sent in every state, before anything else, until it is confirmed") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const ProjectorLightTransition* found = find(state, E::LightOffWanted);
    REQUIRE(found != nullptr);
    CHECK(is_turned_off(found->to));
    const bool again = is_turned_off(state);
    CHECK(found->done().front() == (again ? F::RepeatLightOff : F::SendLightOff));
    CHECK((may_shine(found->to) || !may_shine(state)));
  }
}

TEST_CASE_METHOD(ProjectorLightTable, "A light counts as on from the first byte of light on or of power on") {
  for (const S state : all_states()) {
    for (const E sent : {E::LightOnSent, E::PowerOnSent}) {
      CAPTURE(name_of(state), name_of(sent));
      const ProjectorLightTransition* found = find(state, sent);
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
  for (const ProjectorLightTransition& t : projector_light_transitions()) {
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
    const ProjectorLightTransition* found = find(S::TurningOn, unconfirmed);
    REQUIRE(found != nullptr);
    CHECK((found->done().front() == F::AskWhetherLit || found->done().front() == F::SendLightOff));
  }
  CHECK(find(S::AskedWhetherLit, E::SaysUnlit)->done().front() == F::SendLightOff);
  // No effect sends light on: only ProjectorLight::turn_on() does.
  for (const ProjectorLightTransition& t : projector_light_transitions())
    if (has(t, F::TellLit)) CHECK(t.to == S::Lit);
}

TEST_CASE_METHOD(ProjectorLightTable,
                 "A light off under way ends with an answer to it, or goes on after a pause") {
  for (const S state : {S::MakingSure, S::TurningOff, S::Overdue}) {
    for (const E answer : {E::LightOffConfirmed, E::LightOffTooEarly, E::LightOffUnanswered,
                           E::LightOffRefused, E::LightOffFailed, E::LightOffGarbled, E::LightOffUnclear}) {
      CAPTURE(name_of(state), name_of(answer));
      const ProjectorLightTransition* found = find(state, answer);
      REQUIRE(found != nullptr);
      const bool goes_on = has(*found, F::RetryLater) || has(*found, F::SendLightOff);
      CHECK(is_turned_off(found->to) == goes_on);
      CHECK((found->to == S::Dark || goes_on || has(*found, F::AskWhetherOn)));
    }
    CHECK(find(state, E::RetryDue)->done().front() == F::RepeatLightOff);
  }
}

TEST_CASE_METHOD(ProjectorLightTable,
                 "A light off that is not confirmed is reported once, and so is its confirmation") {
  for (const ProjectorLightTransition& t : projector_light_transitions()) {
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
