#include "hw/gpio/gpio_axis.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include "hw/gpio/axis_motion.hpp"
#include "hw/gpio/axis_words.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

// A limit switch that is closed this far from where it closes is out of place: more than any switch's
// hysteresis.
constexpr Nanometers kSwitchReach{1'000'000};

const GpioAxisConfig& checked(const GpioAxisConfig& config) {
  if (const auto what = contradiction(config)) throw HardwareError(*what);
  return config;
}

AxisInputs::Lines input_lines(const GpioAxisConfig& config, const AxisLines& lines) {
  AxisInputs::Lines inputs;
  const std::array debounce{config.limit_switch.debounce,
                            config.second_switch ? config.second_switch->debounce : Duration{},
                            config.emergency_stop ? config.emergency_stop->debounce : Duration{},
                            config.lid ? config.lid->debounce : Duration{}};
  for (std::size_t i = 0; i < kAxisInputs; ++i)
    inputs.contacts[i] = {lines.inputs[i].get(), debounce[i]};
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

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config)
    : GpioAxis(clock, watcher, config, real_parts(config)) {}

GpioAxis::GpioAxis(Clock& clock, DescriptorWatcher& watcher, const GpioAxisConfig& config, Parts parts)
    : clock_(clock),
      config_(checked(config)),
      screw_(config.microsteps_per_mm, config.backlash),
      lines_(std::move(parts.lines)),
      engine_(*lines_.step, *lines_.direction, {config.pulse_width, config.direction_setup}, parts.now),
      inputs_(engine_, input_lines(config, lines_), parts.now),
      plausibility_(config.encoder ? std::optional<EncoderPlausibility>(*config.encoder) : std::nullopt),
      watch_end_(watcher.when_readable(engine_.ended().descriptor(), [this] { run_ended(); })),
      watch_inputs_(watcher.when_readable(inputs_.changes().descriptor(), [this] { inputs_changed(); })),
      threads_(parts.start_threads(engine_, inputs_)) {}

GpioAxis::~GpioAxis() {
  engine_.bar();
}

// Steps.

void GpioAxis::when_ready(std::function<void()> call) {
  if (engine_.moving()) {  // a run that was aborted has yet to end
    ready_ = [this, call = std::move(call)]() mutable { when_ready(std::move(call)); };
    return;
  }
  rest_ = now_at();
  if (plausibility_) plausibility_->move_begins(inputs_.illegal_encoder_edges());
  if (engine_.barred()) return after(Duration{0}, [this] { blocked(); });
  if (enabled_ || !lines_.enable) return call();
  if (!lines_.enable->set(true)) {
    return after(Duration{0}, [this] {
      line_refused_ = true;
      fail({HomingResult::Fault,
            "the kernel refuses to set the motor's enable line, " + words_of(*config_.enable)});
    });
  }
  enabled_ = true;
  after(config_.enable_settle, std::move(call));
}

void GpioAxis::run(Way way, std::int64_t steps, MillimetersPerSecond speed, std::function<void()> then) {
  then_ = std::move(then);
  run_ = {way, engine_.position() + steps, speed};
  run_on();
}

// The run, or what an emergency stop that did not last has left of it.
void GpioAxis::run_on() {
  if (inputs_.doubtful(AxisInput::EmergencyStop)) {
    ready_ = [this] { run_on(); };
    return;
  }
  rest_ = now_at();
  trip_.reset();
  end_.reset();
  running_ = true;
  begin_following();
  const std::int64_t steps = run_.target - engine_.position();
  engine_.forget_halt();
  set_rules(run_.way, steps * towards_switch() > 0);
  // Without an encoder, a position that was known is lost with the motor's step.
  engine_.start({steps, motion_limits(config_, run_.speed), pull_in(), position_known_ && !config_.encoder});
}

// A rule that is broken already halts at once.
void GpioAxis::set_rules(Way way, bool towards_switch) {
  const bool at_other_end = inputs_.active(AxisInput::SecondSwitch);
  inputs_.watch_second_switch(config_.second_switch && !(at_other_end && towards_switch));
  if (way == Way::Seek) return inputs_.set_limit_rule(LimitRule::AtContact);
  if (way == Way::BackOff) return inputs_.set_limit_rule(LimitRule::Never);
  const Nanometers reach = config_.homes_upwards ? -kSwitchReach : kSwitchReach;
  inputs_.set_limit_rule(LimitRule::Beyond, screw_.nearest_step(config_.switch_height + reach),
                         config_.homes_upwards);
}

void GpioAxis::after(Duration wait, std::function<void()> call) {
  wait_ = clock_.call_after(wait, std::move(call));
}

void GpioAxis::run_ended() {
  engine_.ended().clear();
  if (engine_.moving()) return;
  const StepEnd last = engine_.last_end();  // before anything can begin the next run
  if (ready_) return go_on();
  if (!running_) return;
  running_ = false;
  rest_ = now_at();
  following_.reset();
  inputs_.set_limit_rule(LimitRule::Never);
  inputs_.watch_second_switch(false);
  end_ = last;
  inputs_changed();  // what a halt was for
  take_end();
}

void GpioAxis::take_end() {
  const auto end = std::exchange(end_, std::nullopt);
  if (!end) return;
  if (engine_.barred()) return blocked();
  if (trip_) return fail(Trip(*trip_));
  if (*end != StepEnd::Stalled) tell_stall();
  if (!moving()) return;  // who was told has aborted it
  switch (*end) {
    case StepEnd::LineRefused:
      line_refused_ = true;
      return fail({HomingResult::Fault, "the kernel refuses to set the step line, " + words_of(config_.step) +
                                            ", or the direction line, " + words_of(config_.direction)});
    case StepEnd::Stalled:
      stalls_told_ = engine_.stalls().count;
      return fail({HomingResult::Fault, stall_words() + ", and where the plate is nobody knows"});
    case StepEnd::Halted:
      return seek_on();
    case StepEnd::Stopped:
      return stop_wanted_ ? end_stopped() : run_on();
    case StepEnd::Completed:
      break;
  }
  if (stop_wanted_) return end_stopped();
  if (const auto then = std::exchange(then_, nullptr)) then();
}

// That of homing's second pass: at its end the motor stops dead, and its position is counted on.
double GpioAxis::pull_in() const {
  return config_.homing_speed.count() / 2 * config_.microsteps_per_mm;
}

std::string GpioAxis::stall_words() const {
  const Stalls stalls = engine_.stalls();
  char words[200];
  std::snprintf(words, sizeof words,
                "the computer was too busy for the motor: at %.3g mm/s a step came %.4g ms late, and above "
                "half the homing speed, %.3g mm/s, a motor that stops dead may lose steps",
                stalls.speed / config_.microsteps_per_mm, static_cast<double>(stalls.late.count()) / 1e6,
                config_.homing_speed.count() / 2);
  return words;
}

// Of a stall that did not end the run.
void GpioAxis::tell_stall() {
  const std::uint64_t stalls = engine_.stalls().count;
  if (std::exchange(stalls_told_, stalls) == stalls) return;
  disturb(Disturbance::Kind::Notice,
          stall_words() + (position_known_ ? "; the encoder says where the plate is" : "; homing went on"));
}

// Moves.

void GpioAxis::move_to(Nanometers target, MillimetersPerSecond speed, std::function<void(MoveResult)> done) {
  move_done_ = std::move(done);
  stop_wanted_ = false;
  if (!position_known_) return after(Duration{0}, [this] { end_move(MoveResult::NotHomed); });
  if (target < Nanometers{0} || target > config_.travel) {
    return after(Duration{0}, [this] { end_move(MoveResult::OutsideTravel); });
  }
  when_ready([this, speed, plate = screw_.nearest_step(target)] {
    approach(plate, speed, [this] { end_move(MoveResult::Reached); });
  });
}

// From below, if the screw has backlash: the plate ends where it bears on the screw.
void GpioAxis::approach(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> then) {
  begin_approach(plate, speed, [this, plate, speed, then = std::move(then)] { verify(plate, speed, then); });
}

void GpioAxis::begin_approach(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> there) {
  const Screw::Rest from = now_at();
  if (plate >= from.plate() || screw_.backlash() == 0) {
    return run(Way::Move, plate - from.motor, speed, std::move(there));
  }
  run(Way::Move, plate - screw_.backlash() - from.motor, speed,
      [this, speed, there = std::move(there)] { run(Way::Move, screw_.backlash(), speed, there); });
}

void GpioAxis::stop() {
  if (!moving()) return;
  stop_wanted_ = true;
  if (running_) return engine_.stop();
  ready_ = nullptr;
  after(Duration{0}, [this] { end_stopped(); });
}

void GpioAxis::abort() noexcept {
  if (!moving()) return;
  engine_.halt();
  position_known_ = false;
  forget();
  homing_done_ = nullptr;
  move_done_ = nullptr;
}

void GpioAxis::forget() noexcept {
  running_ = false;
  end_.reset();
  inputs_.set_limit_rule(LimitRule::Never);
  inputs_.watch_second_switch(false);
  seek_.reset();
  wait_.reset();
  following_.reset();
  then_ = nullptr;
  ready_ = nullptr;
}

// Endings.

void GpioAxis::end_move(MoveResult result) {
  forget();
  if (const auto done = std::exchange(move_done_, nullptr)) done(result);
}

void GpioAxis::end_homing(HomingResult result) {
  forget();
  if (const auto done = std::exchange(homing_done_, nullptr)) done(result);
}

void GpioAxis::end_stopped() {
  if (homing_done_) return end_homing(HomingResult::Stopped);
  end_move(MoveResult::Stopped);
}

void GpioAxis::fail(const Trip& trip) {
  if (moving()) {
    engine_.halt();
    position_known_ = false;
    forget();
  }
  // The one who is told may abort: nothing is left to answer then.
  disturb(Disturbance::Kind::Fault, trip.what, trip.emergency_stop);
  if (homing_done_) return end_homing(trip.homing);
  if (move_done_) end_move(MoveResult::Fault);
}

void GpioAxis::disturb(Disturbance::Kind kind, const std::string& what, bool owner_decides) {
  if (disturbed_) disturbed_({kind, what, owner_decides});
}

// Where the plate is.

std::optional<Nanometers> GpioAxis::height() const {
  if (!position_known_) return std::nullopt;
  return screw_.height(config_.encoder ? measured_plate() : static_cast<double>(now_at().plate()));
}

std::optional<Nanometers> GpioAxis::height_at(TimePoint time) const {
  if (!position_known_) return std::nullopt;
  const double made = static_cast<double>(screw_.moved(rest_, engine_.position_at(time)).plate());
  const double off = config_.encoder ? measured_plate() - static_cast<double>(now_at().plate()) : 0;
  return screw_.height(made + off);
}

std::string GpioAxis::where() const {
  if (!position_known_) return "";
  return " at " + millimeters(to_millimeters(*height()).count());
}

}  // namespace contourd
