#include "hw/gpio/gpio_axis.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/gpio_lines.hpp"
#include "hw/hardware_error.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {
namespace {

const GpioAxisConfig& checked(const GpioAxisConfig& config) {
  if (const auto what = contradiction(config)) throw HardwareError(*what);
  return config;
}

// A contact that an axis can have; no config if it is not fitted.
struct Fitting {
  const char* name;
  const GpioInputConfig* config;
};

// Returns the contacts by AxisInput.
std::array<Fitting, kAxisInputs> contacts_of(const GpioAxisConfig& config) {
  const auto optional = [](const char* name, const std::optional<GpioInputConfig>& input) {
    return Fitting{name, input ? &*input : nullptr};
  };
  return {Fitting{"limit switch", &config.limit_switch},
          optional("second switch", config.second_switch),
          optional("emergency stop", config.emergency_stop),
          optional("lid", config.lid),
          optional("power fail", config.power_fail),
          Fitting{kForceInput, config.force ? &config.force->input : nullptr}};
}

constexpr const char *kEncoderA = "encoder A", *kEncoderB = "encoder B", *kEncoderIndex = "encoder index";

// Takes all lines that the config names and leaves the motor disabled. Throws HardwareError.
AxisLines take_lines(const GpioAxisConfig& config) {
  AxisLines lines;
  if (config.enable) lines.enable = std::make_unique<GpioOutput>(*config.enable, "enable", false);
  lines.step = std::make_unique<GpioOutput>(config.step, "step", false);
  lines.direction = std::make_unique<GpioOutput>(config.direction, "direction", false);
  for (std::size_t i = 0; i < kAxisInputs; ++i) {
    if (const auto [name, input] = contacts_of(config)[i]; input != nullptr)
      lines.inputs[i] = std::make_unique<GpioInput>(input->logical_line(), input->bias, name);
  }
  if (const auto& encoder = config.encoder) {
    lines.encoder_a = std::make_unique<GpioInput>(encoder->a, encoder->bias, kEncoderA);
    lines.encoder_b = std::make_unique<GpioInput>(encoder->b, encoder->bias, kEncoderB);
    if (encoder->index)
      lines.encoder_index = std::make_unique<GpioInput>(*encoder->index, encoder->bias, kEncoderIndex);
  }
  return lines;
}

AxisInputs::Lines input_lines(const GpioAxisConfig& config, const AxisLines& lines) {
  AxisInputs::Lines inputs;
  const auto contacts = contacts_of(config);
  for (std::size_t i = 0; i < kAxisInputs; ++i)
    inputs.contacts[i] = {lines.inputs[i].get(),
                          contacts[i].config ? contacts[i].config->debounce : Duration{}};
  inputs.encoder_a = lines.encoder_a.get();
  inputs.encoder_b = lines.encoder_b.get();
  inputs.encoder_index = lines.encoder_index.get();
  return inputs;
}

GpioAxis::Parts real_parts(const GpioAxisConfig& config) {
  return {take_lines(checked(config)), monotonic_now,
          [priority = config.realtime_priority](StepEngine& engine, AxisInputs& inputs) {
            return std::make_unique<RealtimeAxisThreads>(engine, inputs, priority);
          }};
}

}  // namespace

std::optional<std::string> contradiction(const GpioAxisConfig& config) {
  const double rate = config.top_speed.count() * config.microsteps_per_mm;
  char words[160];
  if (rate > kMaxStepsPerSecond) {
    std::snprintf(words, sizeof words,
                  "the axis' top speed of %g mm/s is %.0f steps/s; a computer makes at most %.0f",
                  config.top_speed.count(), rate, kMaxStepsPerSecond);
    return words;
  }
  const double most = most_steps_per_second(config.pulse_width);
  if (rate <= most) return std::nullopt;
  std::snprintf(
      words, sizeof words,
      "the axis' top speed of %g mm/s is %.0f steps/s; pulses and pauses of %g us allow at most %.0f",
      config.top_speed.count(), rate, static_cast<double>(config.pulse_width.count()) / 1e3,
      std::floor(most));
  return words;
}

std::unique_ptr<ZAxis> open_device(const GpioAxisConfig& config, Clock& clock, DescriptorWatcher& watcher) {
  return std::make_unique<GpioAxis>(clock, watcher, config);
}

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config)
    : GpioAxis(clock, watcher, config, real_parts(config)) {}

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config, Parts parts)
    : config_(checked(config)),
      lines_(std::move(parts.lines)),
      engine_(*lines_.step, *lines_.direction, {config.pulse_width, config.direction_setup}, parts.now),
      inputs_(engine_, input_lines(config, lines_), parts.now),
      position_(config_, engine_, inputs_),
      drive_(clock, config_, lines_.enable.get(), engine_, inputs_, position_, drive_wiring()),
      approach_(drive_, position_, {drive_wiring().fail, drive_wiring().notice}),
      homing_(config_, homing_wiring()),
      interlocks_(config_, engine_, inputs_, interlocks_wiring()),
      watch_end_(watcher.when_readable(engine_.ended().descriptor(), [this] { drive_.engine_ended(); })),
      watch_inputs_(watcher.when_readable(inputs_.changes().descriptor(), [this] { inputs_changed(); })),
      threads_(parts.start_threads(engine_, inputs_)) {}

AxisDrive::Wiring GpioAxis::drive_wiring() {
  return {.fail = [this](const AxisFault& fault) { this->fail(fault); },
          .notice =
              [this](const std::string& what) {
                report({MachineEvent::Kind::Notice, what});
              },
          .stopped =
              [this] {
                if (homing_.under_way()) return homing_.stopped();
                end_move(MoveResult::Stopped);
              },
          .blocked = [this] { interlocks_.blocked(); },
          .take_changes = [this] { inputs_changed(); },
          .take_contact = [this] { return take_contact(); },
          .resisted = [this] { resisted(); }};
}

Homing::Wiring GpioAxis::homing_wiring() {
  const auto towards_switch = [this](Nanometers distance) {
    return (config_.homes_upwards ? 1 : -1) * position_.screw().nearest_step(distance);
  };
  return {
      .forget_position = [this] { position_.homing_begins(); },
      .get_ready = [this](Homing::Call ready) { drive_.begin(std::move(ready)); },
      .switch_closed = [this] { return inputs_.active(AxisInput::LimitSwitch); },
      .run = [this, towards_switch](
                 AxisDrive::RunKind kind, Nanometers distance, MillimetersPerSecond speed,
                 Homing::Call over) { drive_.run(kind, towards_switch(distance), speed, std::move(over)); },
      .run_on = [this] { drive_.run_on(); },
      .end_run = [this] { drive_.end_run(); },
      .turning = [this] { return drive_.turning(); },
      .after = [this](Duration time, Homing::Call call) { drive_.after(time, std::move(call)); },
      .take_position = [this](TimePoint edge) { position_.take_switch(edge); },
      .know_position = [this] { position_.become_known(); },
      .approach =
          [this](Homing::Call there) {
            // The few steps back to the switch's height are no way down on which anything could lie.
            position_.expect_contact_at(config_.switch_height);
            approach_.begin(position_.screw().nearest_step(config_.switch_height), config_.homing_speed,
                            [this, there = std::move(there)] {
                              position_.expect_contact_at({});
                              there();
                            });
          },
      .stop = [this] { drive_.stop(); },
      .forget = [this] { drive_.forget(); }};
}

AxisInterlocks::Wiring GpioAxis::interlocks_wiring() {
  return {.fail = [this](const AxisFault& fault) { this->fail(fault); },
          .report = [this](const MachineEvent& event) { this->report(event); },
          .slow_down = [this] { drive_.slow_down(); },
          .halted_for = [this](const AxisFault& cause) { drive_.halted_for(cause); },
          .takes_contact = [this](const InputChange& change) { return takes_contact(change); },
          .where = [this] { return position_.where(); },
          .force_changed = [this](const InputChange& change) { force_changed(change); }};
}

void GpioAxis::home(std::function<void(HomingResult)> done) {
  expects(!moving(), "the axis does not move");
  homing_.begin(std::move(done));
}

void GpioAxis::move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  move_done_ = std::move(done);
  if (!position_.known()) return drive_.after(Duration{0}, [this] { end_move(MoveResult::NotHomed); });
  if (target < Nanometers{0} || target > config_.travel)
    return drive_.after(Duration{0}, [this] { end_move(MoveResult::OutsideTravel); });
  drive_.begin([this, speed, plate = position_.screw().nearest_step(target)] {
    approach_.begin(plate, speed, [this] { end_move(MoveResult::Reached); });
  });
}

// The plate approaches the start first, which takes up the screw's backlash and checks the encoder.
void GpioAxis::rise(const RisePlan& plan, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  move_done_ = std::move(done);
  if (const auto refusal = why_not(plan))
    return drive_.after(Duration{0}, [this, refusal] { end_move(*refusal); });
  drive_.begin([this, plan] {
    approach_.begin(position_.screw().nearest_step(plan.points.front().height), pull_in_speed(config_),
                    [this, plan] { follow(plan); });
  });
}

std::optional<MoveResult> GpioAxis::why_not(const RisePlan& plan) const {
  if (!position_.known()) return MoveResult::NotHomed;
  if (!can_follow(plan, std::min(config_.top_speed, pull_in_speed(config_)), config_.acceleration))
    return MoveResult::PlanRefused;
  const Nanometers first = plan.points.front().height, last = plan.points.back().height;
  if (first < Nanometers{0} || last > config_.travel) return MoveResult::OutsideTravel;
  const Microsteps off = position_.screw().nearest_step(first) - position_.by_steps().plate();
  if (off > Microsteps{1} || off < Microsteps{-1}) return MoveResult::PlanRefused;
  return std::nullopt;
}

void GpioAxis::follow(const RisePlan& plan) {
  const Microsteps from = position_.by_steps().plate();
  const Microsteps to = position_.screw().nearest_step(plan.points.back().height);
  drive_.rise(
      std::make_shared<const RiseCurve>(plan, config_.microsteps_per_mm, static_cast<double>(from.count())),
      to - from,
      [this, to] { approach_.begin(to, pull_in_speed(config_), [this] { end_move(MoveResult::Reached); }); });
}

void GpioAxis::nudge(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  expects(distance >= -kLongestNudge && distance <= kLongestNudge, "a nudge is short");
  move_unhomed(distance, speed, std::move(done));
}

void GpioAxis::raise(Nanometers distance, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  expects(!moving(), "the axis does not move");
  expects(distance >= Nanometers{} && distance <= travel(), "the plate rises within its travel");
  move_unhomed(distance, speed, std::move(done));
}

void GpioAxis::assume_height(Nanometers height) {
  expects(!moving(), "the axis does not move");
  position_.assume(height);
}

void GpioAxis::move_unhomed(Nanometers distance, MillimetersPerSecond speed,
                            std::function<void(MoveResult)> done) {
  move_done_ = std::move(done);
  nudged_ = true;
  position_.forget();
  drive_.begin([this, speed, steps = position_.screw().nearest_step(distance)] {
    const bool towards_switch = (steps > Microsteps{0}) == config_.homes_upwards;
    const bool at_switch = inputs_.active(AxisInput::LimitSwitch);
    if (at_switch && towards_switch) return end_move(MoveResult::AtSwitch);
    // Away from a closed switch, the switch opens on the way; otherwise its first edge halts the motor.
    drive_.run(at_switch ? AxisDrive::RunKind::BackOff : AxisDrive::RunKind::Nudge, steps, speed,
               [this] { end_move(MoveResult::Reached); });
  });
}

// Handles a contact of the limit switch that has halted the motor. False unless homing or a nudge expected
// it.
bool GpioAxis::takes_contact(const InputChange& change) {
  if (homing_.in_pass()) {
    homing_.contact(change);
    return true;
  }
  if (!nudged_) return false;
  nudge_met_switch_ = true;
  if (!drive_.turning()) (void)take_contact();
  return true;
}

// Passes the contact on to homing, or ends a nudge, even if the contact did not last.
bool GpioAxis::take_contact() {
  if (homing_.under_way()) return homing_.take_contact();
  if (!nudge_met_switch_) return false;
  end_move(MoveResult::AtSwitch);
  return true;
}

// Reads the present levels of all inputs.
std::vector<AxisInputState> GpioAxis::inputs() const {
  std::vector<AxisInputState> states;
  const auto add = [&states](const char* name, const GpioLineConfig& where, InputLine& line,
                             std::uint64_t edges) {
    states.push_back({name, describe(where), line.level(), edges});
  };
  for (std::size_t i = 0; i < kAxisInputs; ++i) {
    if (const auto [name, contact] = contacts_of(config_)[i]; contact != nullptr)
      add(name, contact->line, *lines_.inputs[i], inputs_.edges(AxisInput{static_cast<std::uint8_t>(i)}));
  }
  if (!config_.encoder) return states;
  add(kEncoderA, config_.encoder->a, *lines_.encoder_a, inputs_.encoder_edges(EncoderLine::A));
  add(kEncoderB, config_.encoder->b, *lines_.encoder_b, inputs_.encoder_edges(EncoderLine::B));
  if (config_.encoder->index) {
    add(kEncoderIndex, *config_.encoder->index, *lines_.encoder_index,
        inputs_.encoder_edges(EncoderLine::Index));
  }
  return states;
}

void GpioAxis::stop() {
  if (homing_.under_way()) return homing_.stop();
  if (move_done_) drive_.stop();
}

void GpioAxis::abort() noexcept {
  if (!moving()) return;
  drive_.halt();
  homing_.abort();
  move_done_ = nullptr;
  nudged_ = nudge_met_switch_ = false;
}

bool GpioAxis::release() {
  expects(!moving(), "the axis does not move");
  return drive_.release();
}

void GpioAxis::inputs_changed() {
  interlocks_.take_changes();
  drive_.go_on();
}

void GpioAxis::end_move(MoveResult result) {
  drive_.forget();
  nudged_ = nudge_met_switch_ = false;
  if (const auto done = std::exchange(move_done_, nullptr)) done(result);
}

void GpioAxis::force_changed(const InputChange& change) {
  if (change.halted) return drive_.halted_for({.homing = HomingResult::Resistance, .what = ""});
  // A copy, because the call may replace it.
  if (const auto call = on_force_) call({change.active, position_.height_at(change.at)});
}

// Ends the motion. The motor has lost no steps, so that a known position stays known.
void GpioAxis::resisted() {
  if (homing_.under_way()) return homing_.failed(HomingResult::Resistance);
  end_move(MoveResult::Resistance);
}

void GpioAxis::fail(const AxisFault& fault) {
  if (moving()) drive_.halt();
  // The callback may abort the motion; then there is no answer left to give.
  report({MachineEvent::Kind::Fault, fault.what, fault.needs_user});
  if (homing_.under_way()) return homing_.failed(fault.homing);
  if (move_done_) end_move(MoveResult::Fault);
}

}  // namespace contourd
