#include "tests/rig/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/models/models.hpp"

namespace contourd::rig {
namespace {

using namespace std::chrono_literals;
using Kind = Happening::Kind;

constexpr Nanometers kLayer{50'000};
constexpr Nanometers kRiseHeight{600'000};
constexpr double kLostCounts = 0.05, kLostCountsUpwards = 0.15;
// How long an ending print waits for darkness.
constexpr Duration kEnding = 5s;
// Longest duration of a print: a projector warms up for at most an hour, and everything else takes minutes.
constexpr Duration kLongestPrint = 2h;
// Longest time until the light is off once everything works again: light off is retried after every timeout.
constexpr Duration kLongestDarkening = 10min;

std::unique_ptr<PrintMode> print_mode(const Scenario& scenario, MachineModel& machine,
                                      PrintObserver& observer) {
  if (scenario.rises) return std::make_unique<ContinuousPrint>(machine, machine.loop, observer);
  return std::make_unique<LayeredPrint>(machine, machine.loop, observer);
}

}  // namespace

World::World(const Scenario& scenario)
    : scenario_(scenario),
      user_(scenario.seed, 2),
      encoder_(scenario.seed, 3),
      machine_(scenario),
      verdict_(scenario.plate_tolerance()),
      process_(print_mode(scenario, machine_, *this)),
      continuous_(dynamic_cast<const ContinuousPrint*>(process_.get())) {
  machine_.on_event([this](const MachineEvent& event) {
    tell(event.what);
    if (event.kind == MachineEvent::Kind::Interlock) process_->interrupt(event.what);
    if (event.kind == MachineEvent::Kind::Fault) process_->fail(event.what);
  });
  machine_.plant.loses_count = [this] {
    const TimePoint now = machine_.plant.clock.now();
    if (now < encoder_loses_until_ && encoder_.chance(kLostCounts)) return true;
    const bool upwards = machine_.plant.direction->level;
    return upwards && now < encoder_loses_upwards_until_ && encoder_.chance(kLostCountsUpwards);
  };
  machine_.changed = [this] { look(); };
  machine_.screen.number = [this] { return number(); };
  machine_.light_asked = [this](Duration part) {
    verdict_.light_asked(number(), process_->layer_top(), part);
  };
  machine_.light_unasked = [this] { verdict_.light_unasked(); };
  machine_.move_asked = [this] { stopped_at_.reset(); };
  machine_.stop_asked = [this] {
    if (stopped_at_ || !machine_.plant.axis->moving()) return;
    stopped_at_ = machine_.plant.motor;
  };
  // Light behind a line is known to the microsecond, and a layer that lacks less than a millisecond counts as
  // complete.
  if (scenario.light != LightKind::Serial && !scenario.has({Kind::LineRefuses, Kind::InputsHeldUp}))
    verdict_.shortfall = 1ms;
  if (scenario.splits) verdict_.frame = DisplayModel::kFrame;
  verdict_.oldest_mask =
      RiseFrames::kFarthest + scenario.step() +
      Nanometers{std::llround(scenario.rise_mm_s * 1e6 * in_seconds(DisplayModel::kFrame))};
  if (!scenario.has({Kind::LoopHeldUp, Kind::LoopHeldUpInWrite, Kind::FlipEventLost, Kind::FlipLost,
                     Kind::DisplayLost}))
    verdict_.latest_picture = DisplayModel::kFrame / 2 + 1ms;
  if (scenario.undisturbed()) {
    const ProjectorTraits& traits = scenario.projector;
    // The gap, ten bytes at 9600 baud, and the projector's own delays.
    verdict_.slack = traits.gap + traits.slower + traits.darkening + traits.thinks + 15ms;
  }
}

PrintPlan World::plan() const {
  PrintPlan plan;
  plan.job = "box";
  const DisplayGeometry display{Pixels{16}, Pixels{12}, Micrometers{100.0}};
  const int layers = scenario_.layers + (scenario_.rises ? static_cast<int>(kRiseHeight / kLayer) : 0);
  const double height = to_millimeters(kLayer).count() * layers;
  HeightIndex box(models::box({0, 0, 0}, {1, 1, static_cast<float>(height)}));
  EngineSettings settings{.display = display};
  if (scenario_.splits) {
    // Half of the box's pixels get a share of the light.
    settings.uniformity.emplace(display.width, display.height);
    for (std::int32_t y = 0; y < display.height.count(); ++y)
      std::ranges::fill(settings.uniformity->row(y), std::uint8_t{255});
    for (std::int32_t y = 0; y < display.height.count() / 2; ++y)
      std::ranges::fill(settings.uniformity->row(y), Verdict::kShare);
    plan.split = std::make_unique<SplitExposure>(PanelTone{1, 2.2}, display.width, display.height);
  }
  plan.engine = std::make_unique<ContourEngine>(std::move(box), settings,
                                                std::vector{PixelMap::true_scale(display, {0.5, 0.5})});
  plan.layers = PrintLayers(LayerStack{kLayer, layers});
  plan.expected_layers = plan.layers.all();
  plan.exposure = [this](std::int32_t layer, Nanometers) { return scenario_.exposure + 100ms * layer; };
  plan.pixel_area_mm2 = 0.01;
  if (scenario_.interrupts_beyond_tolerance) plan.tolerance.policy = ExposureTolerance::Policy::Interrupt;
  plan.motion.lift = Nanometers{1'000'000};
  plan.motion.lift_speed = MillimetersPerSecond{2};
  plan.motion.retract_speed = plan.travel_speed = plan.homing_speed = MillimetersPerSecond{5};
  plan.motion.settle = scenario_.settle;
  plan.motion.rest = scenario_.rest;
  if (scenario_.has({Kind::PressForce})) {
    plan.motion.lift = plan.motion.second_lift = Nanometers{500'000};
    plan.motion.second_lift_speed = MillimetersPerSecond{4};
    plan.force =
        ForcePolicy{.contact_from = machine_.plant.config.force->contact_from, .least_peel_area_mm2 = 1e9};
  }
  if (scenario_.rises) plan.rises = rises();
  return plan;
}

// Returns a rise above the layers, which the user can change.
PlannedRises World::rises() const {
  PlannedRises rises;
  const Nanometers bottom = kLayer * scenario_.layers, top = bottom + kRiseHeight;
  rises.slowest = MillimetersPerSecond{5.0 / 3600};
  rises.bounds = {.lit = {{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{30}, Micrometers{30}},
                  .margin = 4,
                  .refill = {.viscosity_pa_s = 0.2, .pressure_kpa = 50},
                  .fastest = MillimetersPerSecond{scenario_.rise_mm_s},
                  .slowest = rises.slowest,
                  .acceleration = MillimetersPerSecondSquared{5},
                  .window = 20min};
  rises.settings = planned_settings(rises.bounds);
  rises.slabs = std::make_shared<const std::vector<RiseSlab>>(
      std::vector{RiseSlab{bottom, Millimeters{1}}, RiseSlab{top, Millimeters{1}}});
  PlannedRise rise{.plan = {}, .first_layer = scenario_.layers};
  const auto point = [](Nanometers height, double mm_s) {
    return RisePoint{height, MillimetersPerSecond{mm_s}, RiseLimit::Cure};
  };
  rise.plan.points = {point(bottom, 0), point(bottom + kRiseHeight / 10, scenario_.rise_mm_s),
                      point(top - kRiseHeight / 10, scenario_.rise_mm_s), point(top, 0)};
  rises.each = {std::move(rise)};
  return rises;
}

bool World::is_in(std::initializer_list<std::string_view> states) const {
  return std::ranges::find(states, process_->state().name) != states.end();
}

bool World::rising() const {
  using enum ContinuousState;
  return continuous_ != nullptr &&
         EnumSet<ContinuousState>{Showing, Igniting, Rising, Slowing, Braking, Darkening}.contains(
             continuous_->continuous_state());
}

// Changes the speed as the control socket does.
void World::change_rises() {
  if (!process_->under_way() || !process_->why_fixed("speed").empty()) return;
  const std::optional<RisesAhead> ahead = process_->rises_ahead();
  if (!ahead) return;
  RiseSettings settings = ahead->settings;
  settings.speed_mm_h = user_.between(5.0, 400.0);
  const auto changed = contourd::change_rises(*ahead, settings);
  if (const auto* const rises = std::get_if<ChangedRises>(&changed)) process_->change(*rises);
}

void World::run() {
  const bool ended = print_all();
  if (!ended)
    verdict_.break_rule("g: a print ends or waits for the user",
                        fmt::format("state \"{}\" for longer than any print takes", process_->state().name),
                        machine_.loop.now());
  tell("everything works from now on");
  machine_.heal();
  const auto dark = [this] {
    return !machine_.lit() && machine_.projector().light_off_unconfirmed().empty();
  };
  if (!run_until(dark, kLongestDarkening))
    verdict_.break_rule(
        "g: the light goes off in the end",
        machine_.lit() ? "it is on" : "it is off: " + machine_.projector().light_off_unconfirmed(),
        machine_.loop.now());
  // After a lost reply, a late and doubled reply to light off cannot be distinguished from the reply to power
  // off.
  const bool is_decidable = scenario_.line.reply_late == 0 || scenario_.line.reply_doubled == 0;
  const auto lamp_off = [this] { return !machine_.lamp_is_on(); };
  if (ended && is_decidable && !run_until(lamp_off, kLongestDarkening))
    verdict_.break_rule("g: the lamp goes off in the end", "it is on", machine_.loop.now());
  // Gives messages under way time to arrive.
  static_cast<void>(run_until([] { return false; }, 40s));
  verdict_.close(machine_.loop.now());
  verdict_.figures.line_faults = machine_.line_faults();
}

bool World::print_all() {
  for (print_ = 0; print_ < scenario_.prints; ++print_) {
    const auto ready = [this] { return machine_.why_not_ready().empty(); };
    if (!run_until(ready, kLongestPrint)) return true;  // the print waits and reports why
    states_ = 0;
    tell("starts");
    process_->start(plan());
    if (!run_until([this] { return !process_->under_way(); }, kLongestPrint)) return false;
    // The user takes the part off.
    static_cast<void>(run_until([] { return false; }, user_.between(0s, 8s)));
  }
  return true;
}

bool World::run_until(const std::function<bool()>& done, Duration longest) {
  const TimePoint end = machine_.loop.now() + longest;
  while (!done()) {
    // A timer at the end keeps the world running until then.
    if (machine_.loop.now() >= end) return false;
    const auto at_end = machine_.plant.clock.call_at(end, [] {});
    step();
  }
  return true;
}

void World::step() {
  machine_.turn();
  look();
}

void World::look() {
  Verdict::Scene scene;
  scene.now = machine_.loop.now();
  scene.lit = machine_.lit();
  scene.stray = machine_.stray();
  scene.picture = machine_.screen.picture();
  scene.lit_pixels = machine_.screen.lit_pixels();
  scene.screen_is_in_use = machine_.screen.in_use();
  scene.plate = machine_.plate();
  scene.state = process_->state().name;
  scene.may_be_lit = is_in({"igniting", "exposing", "rising", "slowing"});
  scene.rises = rising();
  scene.light_off_unconfirmed = scene.lit && machine_.light_off_unconfirmed();
  scene.light_off_due = machine_.light_off_due();
  scene.off_sent = machine_.off_sent();
  scene.longest_pause = machine_.longest_light_off_pause();
  scene.flips = machine_.screen.flips();
  // A loop that was held up notices that the mask is too old within two refreshes.
  scene.loop_runs = scene.now > machine_.loop.held_up_until() + 2 * DisplayModel::kFrame;
  verdict_.look(scene);
  look_at_motion();
}

void World::look_at_motion() {
  const std::int64_t motor = machine_.plant.motor;
  if (stopped_at_) {
    // Braking distance of the print's fastest move, from 5 mm/s at 50 mm/s^2, and a step.
    constexpr double kBraking_mm = 5.0 * 5.0 / 2 / 50;
    const double ran_mm = std::fabs(static_cast<double>(motor - *stopped_at_)) / scenario_.steps_per_mm();
    const double most_mm = kBraking_mm + 1 / scenario_.steps_per_mm();
    if (ran_mm > most_mm)
      verdict_.break_rule(
          "e: a stop is within the braking distance",
          fmt::format("{:.3f} mm after stop, the profile needs at most {:.3f} mm", ran_mm, most_mm),
          machine_.loop.now());
  }
  look_at_force();
  const ZAxis& axis = machine_.z_axis();
  if (axis.moving()) return;
  const auto height = axis.height();
  if (height && std::abs((*height - machine_.plate()).count()) > scenario_.plate_tolerance().count())
    verdict_.break_rule("f: the position believed is true",
                        fmt::format("{:.4f} mm believed, {:.4f} mm true", to_millimeters(*height).count(),
                                    to_millimeters(machine_.plate()).count()),
                        machine_.loop.now());
}

// Checks that a plate which meets resistance comes to rest, unless the inputs or steps are late. While it
// homes, it may go on a little.
void World::look_at_force() {
  const std::int64_t motor = machine_.plant.motor;
  const bool settled = machine_.z_axis().force() == true;
  const bool late = scenario_.has({Kind::InputsHeldUp, Kind::StepsHeldUp});
  if (!settled || late || machine_.plate() <= machine_.normal_force_up_to()) return pressed_at_.reset();
  pressed_at_ = std::max(pressed_at_.value_or(motor), motor);
  constexpr double kBraking_mm = (5.0 * 5.0 - 2.5 * 2.5) / 2 / 50;
  const double most_mm = kBraking_mm + in_mm(machine_.plant.config.force->contact_from) +
                         in_mm(machine_.plant.config.backlash) + 2 / scenario_.steps_per_mm();
  const double went_mm = static_cast<double>(*pressed_at_ - motor) / scenario_.steps_per_mm();
  if (went_mm > most_mm)
    verdict_.break_rule("l: a plate that meets resistance comes to rest",
                        fmt::format("{:.3f} mm down, at most {:.3f} mm are needed", went_mm, most_mm),
                        machine_.loop.now());
}

void World::state_changed(const PrintState& entered) {
  tell(fmt::format("-> {}", entered.name));
  ++states_;
  if (!std::exchange(ending_, entered.ending) && ending_) ending_since_ = machine_.loop.now();
  if (is_in({"paused", "held"}))
    user_timer_ = machine_.loop.call_after(user_.between(Duration{500ms}, Duration{5s}), [this] { tend(); });
  if (print_ > 0) return;
  for (const Happening& happening : scenario_.happenings) {
    if (happening.state != states_) continue;
    timers_.push_back(
        machine_.plant.clock.call_after(happening.after, [this, happening] { happen(happening); }));
  }
}

// Acts as a user in front of a waiting print.
void World::tend() {
  if (!is_in({"paused", "held"})) return;
  if (!machine_.why_not_ready().empty()) {
    user_timer_ = machine_.loop.call_after(1s, [this] { tend(); });
  } else if (user_.chance(0.85)) {
    process_->resume();
  } else {
    process_->cancel();
  }
}

void World::happen(const Happening& happening) {
  ++verdict_.figures.happenings;
  tell(describe(happening));
  switch (happening.kind) {
    case Kind::Pause:
      return machine_.loop.post([this] {
        if (process_->under_way()) process_->pause();
      });
    case Kind::Resume:
      return machine_.loop.post([this] {
        if (process_->under_way() && machine_.why_not_ready().empty()) process_->resume();
      });
    case Kind::Cancel:
      return machine_.loop.post([this] { process_->cancel(); });
    case Kind::Fail:
      return machine_.loop.post([this] { process_->fail("contourd is stopped"); });
    case Kind::OpenLid:
    case Kind::ChatteringLid:
      return press(AxisInput::Lid, happening);
    case Kind::PressStop:
    case Kind::ChatteringStop:
      return press(AxisInput::EmergencyStop, happening);
    case Kind::LoopHeldUp:
      return machine_.loop.hold_up(happening.length);
    case Kind::LoopHeldUpInWrite:
      return machine_.hold_up_next_write(happening.length);
    case Kind::StepsHeldUp:
      return machine_.plant.hold_up_steps(happening.length);
    case Kind::InputsHeldUp:
      return machine_.plant.preempt_for(happening.length);
    case Kind::AdapterUnplugged:
      return machine_.unplug_adapter(happening.length);
    case Kind::FlipEventLost:
      return machine_.screen.lose_next_event();
    case Kind::FlipLost:
      return machine_.screen.lose_next_flip();
    case Kind::DisplayLost:
      return machine_.lose_display(happening.length);
    case Kind::LineRefuses:
      return machine_.refuse_line(happening.length);
    case Kind::PressForce:
      return press(AxisInput::Force, happening);
    case Kind::RiseChanges:
      return machine_.loop.post([this] { change_rises(); });
    case Kind::EncoderLoses:
      encoder_loses_until_ = machine_.plant.clock.now() + happening.length;
      return;
    case Kind::EncoderLosesUpwards:
      encoder_loses_upwards_until_ = machine_.plant.clock.now() + happening.length;
      return;
  }
}

void World::press(AxisInput input, const Happening& happening) {
  if (input != AxisInput::Force) expect_dark_soon();
  for (int i = 0; i < 2 * happening.times; ++i) {
    timers_.push_back(machine_.plant.clock.call_after(
        happening.length * i, [this, input, pressed = i % 2 == 0] { machine_.plant.press(input, pressed); }));
  }
}

// Checks that the light goes off after a safety input's first edge, if no other event interferes.
void World::expect_dark_soon() {
  const std::optional<Duration> within = scenario_.darkening_after_edge();
  if (!machine_.lit() || machine_.stray() || !within) return;
  timers_.push_back(machine_.plant.clock.call_after(*within, [this, within] {
    if (machine_.lit())
      verdict_.break_rule("i: light goes off at a safety input's first edge",
                          fmt::format("it is still on {:.1f} ms later", in_seconds(*within) * 1000),
                          machine_.loop.now());
  }));
}

void World::keep_story() {
  keeps_story_ = true;
  machine_.on_message([this](const std::string& what) { tell("  " + what); });
}

void World::tell(const std::string& what) {
  if (keeps_story_)
    story_.push_back(fmt::format("{:9.4f} s  print {}: {}",
                                 in_seconds(machine_.loop.now().time_since_epoch()), print_, what));
}

void World::layer_done(const LayerRecord& layer) {
  tell(fmt::format("layer {} recorded, {} parts", layer.layer, layer.exposure_parts));
  if (layer.rises) return verdict_.slice_recorded(print_ * 1000 + kRise, layer);
  verdict_.recorded(print_ * 1000 + layer.layer, layer, machine_.loop.now());
}

void World::interrupted(const std::string& what) {
  tell("interrupted: " + what);
  ++verdict_.figures.interruptions;
}

void World::print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan) {
  tell(fmt::format("{} {}", name_of(outcome), reason));
  const TimePoint now = machine_.loop.now();
  // A projector found in place of a lost one is responsible only for itself.
  const bool is_decidable = !scenario_.has({Kind::AdapterUnplugged});
  if (machine_.lit() && !machine_.stray() && is_decidable && now - ending_since_ < kEnding)
    verdict_.break_rule("c: a print ends in the dark, or has waited for it",
                        fmt::format("it ends with the light on, {:.3f} s after its end began",
                                    in_seconds(now - ending_since_)),
                        now);
  Figures& figures = verdict_.figures;
  ++figures.prints;
  figures.done += outcome == PrintOutcome::Done ? 1 : 0;
  figures.canceled += outcome == PrintOutcome::Canceled ? 1 : 0;
  figures.failed += outcome == PrintOutcome::Failed ? 1 : 0;
}

}  // namespace contourd::rig
