#include "tests/rig/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "hw/gpio/gpio_axis_config.hpp"
#include "tests/models/dice.hpp"
#include "tests/rig/theme.hpp"

namespace contourd::rig {
namespace {

using namespace std::chrono_literals;
using Kind = Happening::Kind;

struct KindTraits {
  Kind kind;
  std::string_view name;
  int weight;
  Duration shortest, longest;  // zero for a momentary happening
};

constexpr std::array kKinds{
    KindTraits{Kind::Pause, "pause", 2, 0s, 0s},
    KindTraits{Kind::Resume, "resume", 1, 0s, 0s},
    KindTraits{Kind::Cancel, "cancel", 2, 0s, 0s},
    KindTraits{Kind::Fail, "fail", 1, 0s, 0s},
    KindTraits{Kind::OpenLid, "lid opened", 3, 20ms, 3s},
    KindTraits{Kind::PressStop, "emergency stop pressed", 3, 20ms, 3s},
    KindTraits{Kind::ChatteringLid, "lid chatters", 2, 500us, 12ms},
    KindTraits{Kind::ChatteringStop, "emergency stop chatters", 2, 500us, 12ms},
    KindTraits{Kind::LoopHeldUp, "loop held up", 5, 1ms, 5s},
    KindTraits{Kind::LoopHeldUpInWrite, "loop held up in a write", 3, 1ms, 2s},
    KindTraits{Kind::StepsHeldUp, "steps held up", 3, 1ms, 4s},
    KindTraits{Kind::InputsHeldUp, "inputs held up", 2, 1ms, 300ms},
    KindTraits{Kind::AdapterUnplugged, "adapter unplugged", 2, 100ms, 20s},
    KindTraits{Kind::FlipEventLost, "flip event lost", 2, 0s, 0s},
    KindTraits{Kind::FlipLost, "flip lost", 2, 0s, 0s},
    KindTraits{Kind::DisplayLost, "display lost", 2, 100ms, 10s},
    KindTraits{Kind::LineRefuses, "light line refuses", 3, 10ms, 8s},
    KindTraits{Kind::EncoderLoses, "encoder loses counts", 2, 1s, 30s},
    KindTraits{Kind::EncoderLosesUpwards, "encoder loses counts upwards", 1, 1s, 30s},
    KindTraits{Kind::RiseChanges, "speed of the rise changed", 2, 0s, 0s},
    KindTraits{Kind::PressForce, "force on the plate", 0, 1ms, 3s},
};

const KindTraits& traits_of(Kind kind) {
  return *std::ranges::find(kKinds, kind, &KindTraits::kind);
}

Kind draw_kind(Dice& dice) {
  std::int64_t all = 0;
  for (const KindTraits& traits : kKinds)
    all += traits.weight;
  std::int64_t left = dice.whole(0, all - 1);
  for (const KindTraits& traits : kKinds) {
    left -= traits.weight;
    if (left < 0) return traits.kind;
  }
  return kKinds.back().kind;
}

constexpr std::int64_t kStates = 36;
// Shares of the scenarios that have a theme, and a rise.
constexpr double kThemed = 0.5, kRises = 0.3, kForces = 0.3;

Happening draw_happening(Dice& dice) {
  Happening happening{draw_kind(dice), static_cast<int>(dice.whole(1, kStates)), {}, {}, 1};
  if (dice.chance(0.8)) happening.after = dice.spread(100us, 2s);
  const KindTraits& traits = traits_of(happening.kind);
  if (traits.longest > 0s) happening.length = dice.spread(traits.shortest, traits.longest);
  const bool chatters = happening.kind == Kind::ChatteringLid || happening.kind == Kind::ChatteringStop;
  if (chatters) happening.times = static_cast<int>(dice.whole(2, 400));
  return happening;
}

ProjectorTraits draw_projector(Dice& dice) {
  using While = ProjectorTraits::WhileWarm;
  ProjectorTraits traits;
  traits.answers_light = dice.chance(0.5);
  traits.echoes = dice.chance(0.3);
  if (dice.chance(0.5)) traits.latency = dice.spread(1ms, 100ms);
  if (dice.chance(0.5)) traits.slower = dice.spread(1ms, 300ms);
  if (dice.chance(0.5)) traits.darkening = dice.spread(1ms, 100ms);
  traits.thinks = dice.spread(5ms, 400ms);
  // The gap is long enough for a doubled reply to arrive before the next command is sent.
  traits.gap = dice.spread(10ms, 200ms);
  traits.warms_up = dice.between(1s, 5s);
  traits.comes_up_lit = dice.chance(0.7);
  traits.left_on = dice.chance(0.1);
  traits.warming_is_on = dice.chance(0.5);
  traits.off_while_warming = std::array{While::Refuses, While::Silent, While::Obeys}[dice.roll() % 3];
  return traits;
}

LineFaults draw_faults(Dice& dice) {
  LineFaults faults;
  if (dice.chance(0.3)) return faults;
  for (double* each : {&faults.command_lost, &faults.command_garbled, &faults.reply_lost,
                       &faults.reply_garbled, &faults.reply_late, &faults.reply_doubled}) {
    if (dice.chance(0.4)) *each = 0.01 * static_cast<double>(dice.whole(1, 12));
  }
  return faults;
}

// Adds forces, some of which come and go. No other draw depends on them.
void draw_forces(Dice& dice, Scenario& scenario) {
  const KindTraits& traits = traits_of(Kind::PressForce);
  for (std::int64_t left = dice.whole(1, 3); left > 0; --left) {
    Happening force{Kind::PressForce, static_cast<int>(dice.whole(1, kStates)), {}, {}, 1};
    force.after = dice.spread(100us, 2s);
    force.length = dice.spread(traits.shortest, traits.longest);
    if (dice.chance(0.3)) force.times = static_cast<int>(dice.whole(2, 20));
    scenario.happenings.push_back(force);
  }
}

// The number of states that a print enters before its rise, without those of its layers, if nothing happens.
constexpr int kBeforeRise = 4;

// Makes the print rise above its layers. Half of what happens comes while the plate rises.
void draw_rise(Dice& dice, Scenario& scenario) {
  scenario.rises = true;
  scenario.splits = false;
  scenario.rise_mm_s = 0.01 * std::pow(11, dice.fraction());  // as many slow rises as fast ones
  for (Happening& happening : scenario.happenings) {
    if (!dice.chance(0.5)) continue;
    happening.state = kBeforeRise + kStatesOfALayer * scenario.layers + static_cast<int>(dice.whole(0, 7));
    happening.after = dice.between(Duration{0}, Duration{8s});
  }
}

}  // namespace

Scenario draw_scenario(std::uint64_t seed) {
  Dice dice(seed, 0);
  Scenario scenario;
  scenario.seed = seed;
  constexpr std::array kLights{LightKind::Serial,        LightKind::Serial,         LightKind::Serial,
                               LightKind::SerialAndLine, LightKind::PoweredAndLine, LightKind::Line};
  scenario.light = kLights[dice.roll() % kLights.size()];
  scenario.projector = draw_projector(dice);
  scenario.line = draw_faults(dice);
  constexpr std::array kEncoders{EncoderKind::None, EncoderKind::None, EncoderKind::Faults,
                                 EncoderKind::Corrects};
  scenario.encoder = kEncoders[dice.roll() % kEncoders.size()];
  scenario.backlash = dice.chance(0.3);
  scenario.interrupts_beyond_tolerance = dice.chance(0.3);
  scenario.prints = dice.chance(0.3) ? 2 : 1;
  scenario.layers = static_cast<int>(dice.whole(1, 3));
  scenario.exposure = dice.spread(20ms, 4s);
  if (dice.chance(0.7)) scenario.settle = dice.spread(10ms, 1s);
  if (dice.chance(0.7)) scenario.rest = dice.spread(10ms, 500ms);
  const std::int64_t count = dice.chance(0.15) ? 0 : dice.whole(1, 4);
  for (std::int64_t i = 0; i < count; ++i)
    scenario.happenings.push_back(draw_happening(dice));
  scenario.splits = Dice(seed, 5).chance(0.5);
  if (Dice rise(seed, 6); rise.chance(kRises)) draw_rise(rise, scenario);
  if (Dice themes(seed, 4); themes.chance(kThemed)) draw_theme(themes, scenario);
  if (Dice forces(seed, 7); forces.chance(kForces)) draw_forces(forces, scenario);
  return scenario;
}

bool Scenario::undisturbed() const {
  return !line.any() && happenings.empty();
}

bool Scenario::has(std::initializer_list<Kind> any) const {
  return std::ranges::any_of(happenings, [any](const Happening& happening) {
    return std::ranges::find(any, happening.kind) != any.end();
  });
}

// If the policy is to correct, corrections for an encoder that loses many counts at once are accepted up to a
// sum, since no program can know better. The same holds if the motor runs on by as much as the encoder loses.
Nanometers Scenario::plate_tolerance() const {
  if (encoder == EncoderKind::None) return step();
  const EncoderConfig limits;
  const bool misled = has({Kind::EncoderLoses, Kind::EncoderLosesUpwards}) &&
                      (encoder == EncoderKind::Corrects || has({Kind::StepsHeldUp}));
  return step() + limits.tolerance + (misled ? limits.most_correction_sum : Nanometers{0});
}

// A light line takes 5 ms. Commands take the time of the message under way, the gap (which a reply within it
// restarts), one command's time on the wire and the projector's own delays.
std::optional<Duration> Scenario::darkening_after_edge() const {
  if (has({Kind::InputsHeldUp, Kind::LineRefuses})) return std::nullopt;
  if (light != LightKind::Serial) return 5ms;
  if (line.any() || has({Kind::LoopHeldUp, Kind::LoopHeldUpInWrite, Kind::AdapterUnplugged}))
    return std::nullopt;
  // Two commands of 8 to 10 bytes, each with its start and stop bits, at 9600 baud.
  return 2 * projector.gap + 20ms + projector.latency + projector.slower + projector.darkening;
}

std::string describe(const Happening& happening) {
  std::string text = fmt::format("{} (state {}, {} us later", traits_of(happening.kind).name, happening.state,
                                 happening.after.count() / 1000);
  if (happening.length > 0s) text += fmt::format(", for {} us", happening.length.count() / 1000);
  if (happening.times > 1) text += fmt::format(", {} times", happening.times);
  return text + ")";
}

std::string describe(const Scenario& scenario) {
  const ProjectorTraits& p = scenario.projector;
  const LineFaults& f = scenario.line;
  std::string text = fmt::format(
      "seed {}: light {}, encoder {}, {} prints of {} layers of {} ms{}\n  projector: {}{}{}{}{}latency {} "
      "us "
      "and "
      "up to {} us, darkens in {} us, thinks {} us and up to {} us over a light, gap {} us, warm in {} ms, "
      "warming light off {}\n  line: "
      "commands lost {:.0f} %, garbled {:.0f} %; replies lost {:.0f} %, garbled {:.0f} %, late {:.0f} %, "
      "doubled "
      "{:.0f} %{}\n",
      scenario.seed, static_cast<int>(scenario.light), static_cast<int>(scenario.encoder), scenario.prints,
      scenario.layers, scenario.exposure / 1ms,
      scenario.rises    ? fmt::format(", then a rise at {:.3f} mm/s", scenario.rise_mm_s)
      : scenario.splits ? ", split"
                        : "",
      p.answers_light ? "answers light, " : "", p.echoes ? "echoes, " : "",
      p.comes_up_lit ? "comes up lit, " : "", p.left_on ? "left on, " : "",
      p.warming_is_on ? "warming is on, " : "", p.latency / 1us, p.slower / 1us, p.darkening / 1us,
      p.thinks / 1us, p.lights_late / 1us, p.gap / 1us, p.warms_up / 1ms,
      static_cast<int>(p.off_while_warming), 100 * f.command_lost, 100 * f.command_garbled,
      100 * f.reply_lost, 100 * f.reply_garbled, 100 * f.reply_late, 100 * f.reply_doubled,
      f.from_light_on ? ", after the first light on" : "");
  for (const Happening& happening : scenario.happenings)
    text += "  " + describe(happening) + "\n";
  return text;
}

}  // namespace contourd::rig
