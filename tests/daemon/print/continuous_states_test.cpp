#include "daemon/print/continuous_states.hpp"

#include <string>

#include "daemon/print/layered_states.hpp"
#include "daemon/print/print_modes.hpp"
#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct ContinuousTable : testing::StateTableFixture<ContinuousTransition, continuous_table> {};

}  // namespace

TEST_CASE_METHOD(ContinuousTable,
                 "Every row of a rise leads to the expected state with the expected effects") {
  check_lines(R"(
started -> layering: print layers (idle)
layering ended -> idle: finish (layering)
rise due -> lowering: light off, black now, lower to rise (layering, lifting, paused)
rest due -> recovering: light off, black now, await oxygen (layering, lifting, paused)
interrupted -> stay: interrupt layers (layering)
cancelled -> stay: cancel layers (layering)
failed -> stay: fail layers (layering)
wait over -> lowering: lower to rise (recovering)
interrupted -> darkening: light off, black now, await dark (recovering, settling, showing, igniting)
cancelled -> darkening: light off, black now, await dark (recovering, settling, showing, igniting)
failed -> ending: light off, black now, abort axis, power off, await dark (recovering, lowering, settling,
    showing, igniting, rising, slowing, braking, darkening, lifting, paused, parking)
move ended -> settling: wait to settle (lowering)
interrupted -> braking: light off, black now, stop axis (lowering, rising, slowing)
cancelled -> braking: light off, black now, stop axis (lowering, rising, slowing)
wait over -> showing: show mask (settling)
mask shown -> igniting: light on (showing)
light on sent -> rising: rise (igniting)
move ended -> darkening: light off, black now, await dark (rising, slowing)
rise broken -> darkening: light off, black now, await dark (rising, slowing)
too fast -> slowing: stop axis (rising)
speeds changed -> slowing: stop axis (rising)
slowed down -> rising: rise on (slowing)
move ended -> darkening: await dark (braking)
interrupted -> stay: light off, black now (braking, darkening, lifting, paused, parking, ending)
cancelled -> stay: light off, black now (braking, darkening, lifting)
light is off -> lifting: lift (darkening)
layers due -> layering: light off, black now, print more layers (lifting, paused)
pause due -> paused (lifting)
rises over -> parking: park (lifting)
cancelled -> parking: light off, black now, park (paused)
move ended -> ending: light off, power off, await dark (parking)
light is off -> idle: finish (ending)
gave up -> idle: finish (ending)
)");
}

TEST_CASE_METHOD(
    ContinuousTable,
    "Every state of a rise can fail, be cancelled and be interrupted, with the light off first") {
  check_structure();
}

TEST_CASE_METHOD(ContinuousTable, "The plate rises in the light only from the state that sent light on") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(has(t, F::Rise) == (t.from == S::Igniting && t.on == E::LightOnSent));
    CHECK(has(t, F::RiseOn) == (t.from == S::Slowing && t.on == E::SlowedDown));
    CHECK(has(t, F::LightOn) == (t.from == S::Showing && t.on == E::MaskShown));
    if (has(t, F::LightOff)) CHECK(t.effects.front() == F::LightOff);
    if (has(t, F::Lift)) CHECK(t.on == E::LightIsOff);
  }
}

TEST_CASE("The states of a rise that a layered print has too are the same to a report") {
  const auto layered = layered_print_states();
  for (const PrintState& state : continuous_print_states()) {
    CAPTURE(state.name);
    const auto same = std::ranges::find(layered, state.name, &PrintState::name);
    if (same != layered.end())
      CHECK(*same == state);
    else
      CHECK(state.number >= layered.size());
  }
  const std::vector<PrintState> all = print_states();
  CHECK(std::ranges::count(all, std::string_view("rising"), &PrintState::name) == 1);
  CHECK(std::ranges::count(all, std::string_view("layering"), &PrintState::name) == 0);
  CHECK(draw_print_states().find("\"continuous: rising\"") != std::string::npos);
}
