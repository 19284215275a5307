#include "tests/rig/theme.hpp"

#include <algorithm>
#include <array>

namespace contourd::rig {
namespace {

using namespace std::chrono_literals;
using Kind = Happening::Kind;

// The number of states that a print has entered, including its first, when it exposes, lifts, or begins after
// a layer (the next layer's lowering, or parking). The numbers assume that nothing happened before.
constexpr int kExposing = 8, kLifting = 12, kAfterALayer = 14;

int in_a_layer(Dice& dice, const Scenario& scenario, int state) {
  return state + kStatesOfALayer * static_cast<int>(dice.whole(0, scenario.layers - 1));
}

template <std::size_t N>
Kind one_of(Dice& dice, const std::array<Kind, N>& kinds) {
  return kinds[dice.roll() % N];
}

// A light line refuses while lit. Only the line itself can report that, whatever the projector behind it
// confirms.
void refuse_in_light(Dice& dice, Scenario& scenario) {
  constexpr std::array kLights{LightKind::SerialAndLine, LightKind::PoweredAndLine, LightKind::Line};
  scenario.light = kLights[dice.roll() % kLights.size()];
  Happening refuses{Kind::LineRefuses, in_a_layer(dice, scenario, kExposing), {}, {}, 1};
  refuses.after = dice.between(Duration{0}, scenario.exposure);
  refuses.length = dice.spread(10ms, 8s);
  scenario.happenings = {refuses};
}

// A safety input chatters long enough to reveal a debounce that every edge restarts.
void chatter_in_light(Dice& dice, Scenario& scenario) {
  scenario.line = {};
  scenario.exposure = std::max<Duration>(scenario.exposure, 500ms);
  const Kind kind = one_of(dice, std::array{Kind::ChatteringLid, Kind::ChatteringStop});
  Happening chatters{
      kind, in_a_layer(dice, scenario, kExposing), {}, {}, static_cast<int>(dice.whole(50, 400))};
  chatters.after = dice.between(Duration{0}, scenario.exposure / 2);
  chatters.length = dice.spread(500us, 4ms);
  scenario.happenings = {chatters};
}

// The encoder loses counts over enough layers for the corrections to add up.
void lose_counts(Dice& dice, Scenario& scenario) {
  scenario.encoder = EncoderKind::Corrects;
  scenario.layers = static_cast<int>(dice.whole(5, 8));
  const Kind kind = one_of(dice, std::array{Kind::EncoderLoses, Kind::EncoderLosesUpwards});
  scenario.happenings = {{kind, static_cast<int>(dice.whole(1, kLifting)), {}, 10min, 1}};
}

// The steps are held up during moves, when the motor is fast.
void stall(Dice& dice, Scenario& scenario) {
  for (std::int64_t i = dice.whole(1, 3); i > 0; --i) {
    const int state = dice.chance(0.3) ? kLifting : kAfterALayer;
    Happening stalls{Kind::StepsHeldUp, in_a_layer(dice, scenario, state), {}, {}, 1};
    stalls.after = dice.between(Duration{0}, Duration{1s});
    stalls.length = dice.spread(1ms, 500ms);
    scenario.happenings.push_back(stalls);
  }
}

// Identical replies arrive in an order from which nothing can be concluded.
void confuse_replies(Dice& dice, Scenario& scenario) {
  scenario.light = dice.chance(0.8) ? LightKind::Serial : LightKind::SerialAndLine;
  scenario.projector.thinks = dice.spread(50ms, 400ms);
  scenario.projector.gap = dice.spread(10ms, 50ms);
  scenario.line = {};
  scenario.line.command_lost = 0.01 * static_cast<double>(dice.whole(5, 30));
  scenario.line.reply_late = 0.01 * static_cast<double>(dice.whole(5, 50));
  if (dice.chance(0.5)) scenario.line.reply_doubled = 0.01 * static_cast<double>(dice.whole(5, 50));
  if (dice.chance(0.5)) scenario.line.reply_lost = 0.01 * static_cast<double>(dice.whole(1, 20));
  if (dice.chance(0.5)) return;
  const Kind kind = one_of(dice, std::array{Kind::Cancel, Kind::Fail, Kind::OpenLid});
  Happening ends{kind, in_a_layer(dice, scenario, kExposing), {}, {}, 1};
  ends.after = dice.between(Duration{0}, scenario.exposure);
  if (kind == Kind::OpenLid) ends.length = dice.spread(20ms, 3s);
  scenario.happenings = {ends};
}

// Light on is obeyed at once but answered only after the print has ended. The replies to the commands sent
// meanwhile come after that one, and are not those to power off.
void answer_light_late(Dice& dice, Scenario& scenario) {
  scenario.light = LightKind::Serial;
  scenario.projector.thinks = dice.spread(200ms, 1s);
  scenario.projector.gap = dice.spread(10ms, 50ms);
  scenario.projector.lights_late = dice.spread(4s, 20s);
  scenario.prints = 2;
  scenario.line = {.from_light_on = true};
  scenario.line.command_lost = 0.01 * static_cast<double>(dice.whole(20, 50));
  Happening ends{Kind::Fail, kExposing, {}, {}, 1};
  ends.after = dice.spread(1ms, 100ms);
  scenario.happenings = {ends};
}

// A light is lost during an exposure and found again before the print has ended, and the end is interrupted.
void interrupt_end(Dice& dice, Scenario& scenario) {
  const bool serial = scenario.light == LightKind::Serial;
  Happening loss{
      serial ? Kind::AdapterUnplugged : Kind::LineRefuses, in_a_layer(dice, scenario, kExposing), {}, {}, 1};
  loss.after = dice.between(Duration{0}, scenario.exposure);
  loss.length = dice.spread(10ms, 5s);
  const Kind kind = one_of(dice, std::array{Kind::OpenLid, Kind::PressStop, Kind::DisplayLost});
  Happening interrupts{kind, loss.state + 1, {}, {}, 1};
  interrupts.after = dice.between(Duration{0}, Duration{5s});
  interrupts.length = dice.spread(20ms, 3s);
  scenario.happenings = {loss, interrupts};
}

}  // namespace

void draw_theme(Dice& dice, Scenario& scenario) {
  constexpr std::array kThemes{refuse_in_light, chatter_in_light,  lose_counts,  stall,
                               confuse_replies, answer_light_late, interrupt_end};
  kThemes[dice.roll() % kThemes.size()](dice, scenario);
}

}  // namespace contourd::rig
