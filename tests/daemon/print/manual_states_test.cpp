#include "daemon/print/manual_states.hpp"

#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct ManualTable : testing::StateTableFixture<ManualTransition, manual_table> {};

}  // namespace

TEST_CASE_METHOD(ManualTable,
                 "Every row of manual control leads to the expected state with the expected effects") {
  check_lines(R"(
home -> homing: home (idle)
move -> moving: move (idle)
nudge -> moving: nudge (idle)
power on -> powering on: light off, power on (idle)
power off -> extinguishing: light off, power off, await dark (idle)
light on -> warming up: light off, power on (idle)
ask status -> asking: ask status (idle)
homed -> idle (homing)
stop -> braking: light off, stop axis (homing, moving)
failed -> extinguishing: light off, black now, abort axis, await dark (homing, moving, braking, powering on,
    warming up, igniting, lit, asking)
move ended -> idle (moving, braking)
projector ready -> idle (powering on)
stop -> extinguishing: light off, black now, await dark (powering on, warming up, igniting, lit, asking)
projector ready -> igniting: light on (warming up)
light on sent -> lit: time light (igniting)
time over -> extinguishing: light off, await dark (lit)
light is off -> idle (extinguishing)
failed -> stay: light off, black now, abort axis (extinguishing)
gave up -> idle: light off, tell that the light may be on (extinguishing)
status told -> idle (asking)
)");
}

TEST_CASE_METHOD(ManualTable,
                 "In manual control, every state can be stopped and can fail, with the light off first") {
  check_structure();
}

TEST_CASE_METHOD(ManualTable,
                 "In manual control, light off always comes first, and the light's end is awaited") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    if (has(t, F::LightOff)) CHECK(t.effects.front() == F::LightOff);
    if (t.to == S::Extinguishing && t.from != S::Extinguishing) CHECK(has(t, F::AwaitDark));
  }
}

TEST_CASE_METHOD(ManualTable, "In manual control, nothing moves while there may be light") {
  for (const Transition& t : transitions()) {
    if (!has(t, F::Home) && !has(t, F::Move) && !has(t, F::Nudge)) continue;
    CHECK(t.from == S::Idle);
    CHECK_FALSE(has(t, F::LightOn));
  }
}
