#include "hw/serial/projector_power_states.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/transition_table_fixture.hpp"

using namespace contourd;

namespace {

struct ProjectorPowerTable
    : testing::TransitionTableFixture<ProjectorPowerTransition, projector_power_transitions> {
  // The expected table, written out separately, row for row.
  static inline const std::vector<Row> kExpected{
      {S::Unknown, E::PowerOnWanted, S::Asking, {F::AskWhetherOn}},
      {S::LeftOn, E::PowerOnWanted, S::Asking, {F::AskWhetherOn}},
      {S::Off, E::PowerOnWanted, S::OffAsking, {F::AskWhetherOn}},
      {S::On, E::PowerOnWanted, S::OnAsking, {F::AskWhetherStillOn}},
      {S::WarmingUpUnused, E::PowerOnWanted, S::WarmingUp, {F::WaitUntilWarm}},
      {S::TurningOff, E::PowerOnWanted, S::Asking, {F::AskWhetherOn}},
      {S::OffOverdue, E::PowerOnWanted, S::Asking, {F::AskWhetherOn}},
      {S::Asking, E::SaysOn, S::Darkening, {F::WatchOver, F::MakeDark}},
      {S::OffAsking, E::SaysOn, S::Darkening, {F::WatchOver, F::MakeDark}},
      {S::OnAsking, E::SaysOn, S::Darkening, {F::WatchOver, F::MakeDark}},
      {S::Asking, E::SaysOnEarly, S::OnWarmingUp, {F::WaitUntilWarm}},
      {S::OffAsking, E::SaysOnEarly, S::OnWarmingUp, {F::WaitUntilWarm}},
      {S::OnAsking, E::SaysOnEarly, S::OnWarmingUp, {F::WaitUntilWarm}},
      {S::Asking, E::SaysOff, S::CoolingDown, {F::WaitUntilCool}},
      {S::Asking, E::SaysUnclear, S::CoolingDown, {F::WaitUntilCool}},
      {S::Asking, E::SaysNothing, S::CoolingDown, {F::WaitUntilCool}},
      {S::OnAsking, E::SaysOff, S::CoolingDown, {F::WaitUntilCool}},
      {S::OnAsking, E::SaysUnclear, S::CoolingDown, {F::WaitUntilCool}},
      {S::OnAsking, E::SaysNothing, S::CoolingDown, {F::WaitUntilCool}},
      {S::OffAsking, E::SaysOff, S::OffCoolingDown, {F::WaitUntilCool}},
      {S::OffAsking, E::SaysUnclear, S::OffCoolingDown, {F::WaitUntilCool}},
      {S::OffAsking, E::SaysNothing, S::OffCoolingDown, {F::WaitUntilCool}},
      {S::CoolingDown, E::Cool, S::SwitchingOn, {F::SendPowerOn}},
      {S::OffCoolingDown, E::Cool, S::SwitchingOn, {F::SendPowerOn}},
      {S::SwitchingOn, E::PowerOnAnswered, S::WarmingUp, {F::WaitUntilWarm, F::SuspectLight}},
      {S::SwitchingOn, E::PowerOnFailed, S::Unknown, {F::Tell}},
      {S::WarmingUp, E::Warm, S::AskingReady, {F::AskWhetherReady}},
      {S::OnWarmingUp, E::Warm, S::Darkening, {F::WatchOver, F::MakeDark}},
      {S::AskingReady, E::SaysOn, S::Darkening, {F::WatchOver, F::MakeDark}},
      {S::AskingReady, E::SaysOff, S::StillOff, {F::Pause}},
      {S::AskingReady, E::SaysUnclear, S::Unready, {F::Pause}},
      {S::AskingReady, E::SaysNothing, S::Unknown, {F::Tell}},
      {S::AskingReady, E::NeverOn, S::Unknown, {F::TellNeverOn}},
      {S::StillOff, E::PauseOver, S::SwitchingOn, {F::SendPowerOn}},
      {S::Unready, E::PauseOver, S::AskingReady, {F::AskWhetherReady}},
      {S::Darkening, E::LightIsOff, S::SetsBrightness, {F::SetBrightness}},
      {S::Darkening, E::LightOffFailed, S::On, {F::Tell}},
      {S::SetsBrightness, E::BrightnessAnswered, S::On, {F::Tell}},
      {S::Asking, E::Dropped, S::Unknown, {}},
      {S::OffAsking, E::Dropped, S::Off, {}},
      {S::OnAsking, E::Dropped, S::On, {}},
      {S::CoolingDown, E::Dropped, S::Unknown, {}},
      {S::OffCoolingDown, E::Dropped, S::Off, {}},
      {S::SwitchingOn, E::Dropped, S::Unknown, {}},
      {S::WarmingUp, E::Dropped, S::WarmingUpUnused, {F::WaitUntilWarm}},
      {S::WarmingUpUnused, E::Warm, S::Unknown, {}},
      {S::AskingReady, E::Dropped, S::Unknown, {}},
      {S::StillOff, E::Dropped, S::Unknown, {}},
      {S::Unready, E::Dropped, S::Unknown, {}},
      {S::OnWarmingUp, E::Dropped, S::Unknown, {}},
      {S::Darkening, E::Dropped, S::On, {}},
      {S::SetsBrightness, E::Dropped, S::On, {}},
      {S::On, E::WentOff, S::Unknown, {F::ReportWentOff}},
      {S::OnAsking, E::WentOff, S::Asking, {F::ReportWentOff}},
      {S::Darkening, E::WentOff, S::Unknown, {F::ReportWentOff, F::TellWentOff}},
      {S::SetsBrightness, E::WentOff, S::Unknown, {F::ReportWentOff, F::TellWentOff}},
      {S::Unknown, E::LeftOnSuspected, S::LeftOn, {F::AskWhetherLeftOn}},
      {S::LeftOn, E::LeftOnSuspected, S::LeftOn, {F::AskWhetherLeftOn}},
      {S::LeftOn, E::PauseOver, S::LeftOn, {F::AskWhetherLeftOn}},
      {S::LeftOn, E::SaysOn, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::LeftOn, E::NotOnYet, S::LeftOn, {F::AskLeftOnSoon}},
      {S::LeftOn, E::SaysNothing, S::LeftOn, {F::AskLeftOnLater}},
      {S::LeftOn, E::SaysOff, S::Unknown, {}},
      {S::LeftOn, E::SaysUnclear, S::Unknown, {}},
      {S::LeftOn, E::LineLost, S::Unknown, {}},
      {S::Unknown, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::LeftOn, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::Asking, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::OnAsking, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::CoolingDown, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::SwitchingOn, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::WarmingUp, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::AskingReady, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::StillOff, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::Unready, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::OnWarmingUp, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::Darkening, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::SetsBrightness, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::On, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::WarmingUpUnused, E::PowerOffWanted, S::TurningOff, {F::LightOff, F::SendPowerOff}},
      {S::Off, E::PowerOffWanted, S::Off, {F::LightOff}},
      {S::OffAsking, E::PowerOffWanted, S::Off, {F::LightOff}},
      {S::OffCoolingDown, E::PowerOffWanted, S::Off, {F::LightOff}},
      {S::TurningOff, E::PowerOffWanted, S::TurningOff, {F::LightOff}},
      {S::OffOverdue, E::PowerOffWanted, S::OffOverdue, {F::LightOff}},
      {S::TurningOff, E::PowerOffConfirmed, S::Off, {F::NoteOff}},
      {S::TurningOff, E::PowerOffUnanswered, S::TurningOff, {F::PowerOffAgain, F::AskWhetherOff}},
      {S::TurningOff,
       E::PowerOffLate,
       S::OffOverdue,
       {F::ReportLampOn, F::PowerOffAgainLater, F::AskWhetherOff}},
      {S::TurningOff, E::PowerOffUnknowable, S::Unknown, {}},
      {S::TurningOff, E::PauseOver, S::TurningOff, {F::SendPowerOff}},
      {S::OffOverdue, E::PowerOffConfirmed, S::Off, {F::NoteOff}},
      {S::OffOverdue, E::PowerOffUnanswered, S::OffOverdue, {F::PowerOffAgainLater, F::AskWhetherOff}},
      {S::OffOverdue, E::PowerOffLate, S::OffOverdue, {F::PowerOffAgainLater, F::AskWhetherOff}},
      {S::OffOverdue, E::PowerOffUnknowable, S::Unknown, {}},
      {S::OffOverdue, E::PauseOver, S::OffOverdue, {F::SendPowerOff}},
      {S::Unknown, E::PowerOffConfirmed, S::Off, {F::NoteOff}},
      {S::Asking, E::PowerOffConfirmed, S::OffAsking, {F::NoteOff}},
      {S::CoolingDown, E::PowerOffConfirmed, S::OffCoolingDown, {F::NoteOff, F::WaitUntilCool}},
      {S::SwitchingOn,
       E::PowerOffConfirmed,
       S::OffCoolingDown,
       {F::DropPowerOn, F::NoteOff, F::WaitUntilCool}},
  };

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
  check_rows(kExpected);
}

TEST_CASE_METHOD(ProjectorPowerTable, "No state of a projector's power has two rows for one event") {
  check_one_row_per_event();
}

TEST_CASE_METHOD(
    ProjectorPowerTable,
    "A power off that is wanted turns the light off first, in every state, and ends a pending power on") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const ProjectorPowerTransition* found = find(state, E::PowerOffWanted);
    REQUIRE(found != nullptr);
    CHECK(found->done().front() == F::LightOff);
    CHECK((is_turned_off(found->to) || found->to == S::Off));
    CHECK((found->to == S::Off) == is_off(state));
  }
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "Power off is sent until it is confirmed, no longer wanted or cannot be known") {
  const std::set<E> ends{E::PowerOffConfirmed, E::PowerOffUnknowable, E::PowerOnWanted};
  for (const ProjectorPowerTransition& t : projector_power_transitions()) {
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
    const ProjectorPowerTransition* found = find(state, E::Dropped);
    CHECK((found != nullptr) == is_wanted(state));
    if (found == nullptr) continue;
    CHECK_FALSE(is_wanted(found->to));
    CHECK(is_off(found->to) == is_off(state));
    CHECK(is_on(found->to) == is_on(state));
    for (const F effect : found->done())
      CHECK(effect == F::WaitUntilWarm);
  }
}

TEST_CASE_METHOD(ProjectorPowerTable,
                 "Power on is sent only where it is wanted, and its light is suspected from then on") {
  for (const ProjectorPowerTransition& t : projector_power_transitions()) {
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
  for (const ProjectorPowerTransition& t : projector_power_transitions()) {
    if (!is_wanted(t.from) || is_wanted(t.to)) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    const bool answered = has(t, F::Tell) || has(t, F::TellNeverOn) || has(t, F::TellWentOff);
    CHECK(answered == (t.on != E::Dropped && t.on != E::PowerOffWanted));
  }
}

TEST_CASE_METHOD(ProjectorPowerTable, "A projector that goes off by itself is reported wherever it was on") {
  for (const S state : all_states()) {
    CAPTURE(name_of(state));
    const ProjectorPowerTransition* found = find(state, E::WentOff);
    CHECK((found != nullptr) == is_on(state));
    if (found == nullptr) continue;
    CHECK(found->done().front() == F::ReportWentOff);
    CHECK_FALSE(is_on(found->to));
  }
}
