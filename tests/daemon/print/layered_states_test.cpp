#include "daemon/print/layered_states.hpp"

#include <algorithm>
#include <set>
#include <span>
#include <string>

#include "daemon/print/print_modes.hpp"
#include "hw/gpio/homing_states.hpp"
#include "hw/serial/projector_light_states.hpp"
#include "hw/serial/projector_power_states.hpp"
#include "tests/catch.hpp"
#include "tests/hw/state_table_fixture.hpp"

using namespace contourd;

namespace {

struct LayeredTable : testing::StateTableFixture<LayeredTransition, layered_table> {};

}  // namespace

TEST_CASE_METHOD(LayeredTable,
                 "Every row of the print process leads to the expected state with the expected effects") {
  check_lines(R"(
started -> warming up: light off, black now, power on (idle)
went on -> awaiting dark: light off, black now, await dark (idle)
projector ready -> homing: home (warming up)
interrupted -> held: light off, black now (warming up)
cancelled -> ending: light off, black now, power off, await dark (warming up, held)
failed -> ending: light off, black now, abort axis, power off, await dark (warming up, homing, lowering,
    settling, showing, igniting, exposing, darkening, extinguishing, interrupting, resting, lifting, awaiting
    dark, raising, paused, held, braking, halting, parking)
homed -> awaiting dark: await dark (homing)
interrupted -> held: light off, black now, abort axis (homing)
cancelled -> ending: light off, black now, abort axis, power off, await dark (homing)
move ended -> settling: wait to settle (lowering)
interrupted -> braking: light off, black now, stop axis (lowering)
cancelled -> halting: light off, black now, stop axis (lowering, lifting, raising, braking)
wait over -> showing: show mask (settling)
interrupted -> lifting: light off, black now, lift (settling, showing, resting)
cancelled -> parking: light off, black now, park (settling, showing, resting, awaiting dark, paused)
mask shown -> igniting: light on (showing)
light on sent -> exposing: time exposure (igniting)
interrupted -> interrupting: light off, black now, await dark (igniting, exposing)
cancelled -> interrupting: light off, black now, await dark (igniting, exposing, darkening, extinguishing)
wait over -> darkening: light off, show black (exposing)
picture due -> stay: show picture (exposing)
screen black -> extinguishing: await dark (darkening)
interrupted -> interrupting: light off, black now, record layer, await dark (darkening, extinguishing)
light is off -> resting: record layer, wait to rest (extinguishing)
light is off -> lifting: lift (interrupting)
interrupted -> stay: light off, black now (interrupting, lifting, raising, paused, held, braking, halting,
    parking, ending)
cancelled -> stay: light off, black now (interrupting)
wait over -> lifting: lift (resting)
move ended -> awaiting dark: await dark (lifting)
layer due -> lowering: record layer, next layer, lower to layer (awaiting dark)
layer unfinished -> lowering: lower to layer (awaiting dark)
pause due -> raising: raise for a look (awaiting dark)
layers done -> parking: record layer, park (awaiting dark)
rise due -> idle: record layer, finish (awaiting dark)
interrupted -> raising: light off, black now, raise for a look (awaiting dark)
move ended -> paused (raising)
resumed -> awaiting dark: await dark (paused)
resumed -> warming up: light off, black now, power on (held)
move ended -> lifting: lift (braking)
move ended -> parking: park (halting)
move ended -> ending: light off, power off, await dark (parking)
light is off -> idle: finish (ending)
gave up -> idle: finish (ending)
)");
}

TEST_CASE_METHOD(
    LayeredTable,
    "Every state of a print can fail, be cancelled and be interrupted, with the light off first") {
  check_structure();
}

TEST_CASE_METHOD(LayeredTable, "Light off is always the first effect of its row") {
  for (const Transition& t : transitions())
    if (has(t, F::LightOff)) CHECK(t.effects.front() == F::LightOff);
}

TEST_CASE_METHOD(LayeredTable,
                 "A failure leads to the print's end, and a print becomes idle only by finishing") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    if (t.on == E::Failed) CHECK(t.to == S::Ending);
    CHECK((t.to == S::Idle) == (!t.effects.empty() && t.effects.back() == F::Finish));
  }
}

TEST_CASE_METHOD(LayeredTable, "An interruption turns the light off and never ends the print") {
  for (const Transition& t : transitions()) {
    if (t.on != E::Interrupted) continue;
    CAPTURE(name_of(t.from));
    CHECK(t.effects.front() == F::LightOff);
    CHECK(t.to != S::Idle);
  }
}

TEST_CASE_METHOD(LayeredTable, "The light goes on only when the mask is on the screen") {
  for (const Transition& t : transitions()) {
    CHECK(has(t, F::LightOn) == (t.from == S::Showing && t.on == E::MaskShown));
  }
}

TEST_CASE_METHOD(LayeredTable, "A later picture is shown only while a layer is exposed, which goes on") {
  for (const Transition& t : transitions()) {
    const bool is_due = t.from == S::Exposing && t.on == E::PictureDue;
    CHECK(has(t, F::ShowPicture) == is_due);
    if (is_due) CHECK(t.to == S::Exposing);
  }
}

TEST_CASE_METHOD(
    LayeredTable,
    "The plate moves down into the resin, and a mask is shown, only after the light is confirmed off") {
  for (const Transition& t : transitions()) {
    CAPTURE(name_of(t.from), name_of(t.on));
    CHECK(has(t, F::LowerToLayer) == (t.to == S::Lowering));
    if (t.to == S::Lowering) CHECK(t.from == S::AwaitingDark);
    if (has(t, F::ShowMask)) CHECK(t.from == S::Settling);
    if (t.to == S::Settling) CHECK(t.from == S::Lowering);
    // A state that waits for the light to be confirmed off is entered with AwaitDark.
    const bool waits =
        t.to == S::AwaitingDark || t.to == S::Extinguishing || t.to == S::Interrupting || t.to == S::Ending;
    if (waits) CHECK((has(t, F::AwaitDark) || t.from == t.to));
  }
}

TEST_CASE_METHOD(LayeredTable, "Nothing moves while there may be light") {
  const std::set<S> lit{S::Igniting, S::Exposing, S::Darkening, S::Extinguishing, S::Interrupting};
  for (const Transition& t : transitions()) {
    if (!lit.contains(t.from)) continue;
    CAPTURE(name_of(t.from), name_of(t.on));
    if (has(t, F::Lift) || has(t, F::Park) || has(t, F::RaiseForALook)) CHECK(t.on == E::LightIsOff);
  }
}

TEST_CASE_METHOD(LayeredTable,
                 "The drawing names every state, including homing and a projector's power and light") {
  const std::string drawing = draw_print_states();
  const auto names_all = [&](const std::string& prefix, std::span<const std::string_view> states) {
    return std::ranges::all_of(states, [&](std::string_view state) {
      return drawing.find("\"" + prefix + std::string(state) + "\"") != std::string::npos;
    });
  };
  CHECK(names_all("", kNames<LayeredState>));
  CHECK(names_all("homing: ", kNames<HomingState>));
  CHECK(names_all("projector power: ", kNames<ProjectorPowerState>));
  CHECK(names_all("projector light: ", kNames<ProjectorLightState>));
}
