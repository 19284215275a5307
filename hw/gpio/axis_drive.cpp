#include "hw/gpio/axis_drive.hpp"

#include <cstdio>
#include <limits>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_fault.hpp"
#include "hw/gpio/axis_motion.hpp"

namespace contourd {
namespace {

// A limit switch that is closed this far from its height is out of place. This is more than any switch's
// hysteresis.
constexpr Nanometers kSwitchReach{1'000'000};
// How often the encoder is checked while the motor turns.
constexpr Duration kFollow{std::chrono::milliseconds{10}};

// Sets the force's rule for a run down. Homing seeks the switch where the plate may press out resin already,
// at a height that is unknown. A force that is there before it begins is none of the resin's. A run that
// backs off goes where the plate came from.
void watch_force(AxisInputs& inputs, const PlatePosition& position, AxisDrive::RunKind kind,
                 Nanometers from) {
  if (kind == AxisDrive::RunKind::BackOff) return;
  if (kind == AxisDrive::RunKind::Move && position.known())
    return inputs.set_force_rule(ForceRule::Above, position.above_contact(from).count());
  if (kind == AxisDrive::RunKind::Seek && !inputs.active(AxisInput::Force))
    return inputs.set_force_rule(ForceRule::Beyond, position.screw().nearest_step(from).count());
  inputs.set_force_rule(ForceRule::Above, std::numeric_limits<std::int64_t>::min());
}

}  // namespace

AxisDrive::AxisDrive(Clock& clock, const GpioAxisConfig& config, OutputLine* enable, StepEngine& engine,
                     AxisInputs& inputs, PlatePosition& position, Wiring wiring)
    : clock_(clock),
      config_(config),
      enable_(enable),
      engine_(engine),
      inputs_(inputs),
      position_(position),
      wiring_(std::move(wiring)) {}

void AxisDrive::begin(std::function<void()> ready) {
  wanted_ = Wanted::Motion;
  when_ready(std::move(ready));
}

void AxisDrive::when_ready(std::function<void()> call) {
  if (engine_.moving()) {  // an aborted run has not ended yet
    ready_ = [this, call = std::move(call)]() mutable { when_ready(std::move(call)); };
    return;
  }
  position_.move_begins();
  if (engine_.inhibited()) return after(Duration{0}, wiring_.blocked);
  if (enabled_ || enable_ == nullptr) return call();
  if (!enable_->set(true)) {
    return after(Duration{0}, [this] {
      line_refused_ = true;
      wiring_.fail(
          {.what = "the kernel refuses to set the motor's enable line, " + describe(*config_.enable)});
    });
  }
  enabled_ = true;
  after(config_.enable_settle, std::move(call));
}

void AxisDrive::run(RunKind kind, Microsteps steps, MillimetersPerSecond speed, std::function<void()> then) {
  run_ = {.kind = kind,
          .target = Microsteps{engine_.position()} + steps,
          .speed = speed,
          .then = std::move(then)};
  run_on();
}

void AxisDrive::rise(std::shared_ptr<const RiseCurve> rise, Microsteps steps, std::function<void()> then) {
  run_ = {.kind = RunKind::Move,
          .target = Microsteps{engine_.position()} + steps,
          .speed = pull_in_speed(config_),
          .then = std::move(then),
          .rise = std::move(rise)};
  run_on();
}

void AxisDrive::run_on() {
  if (inputs_.debouncing(AxisInput::EmergencyStop)) {
    ready_ = [this] { run_on(); };
    return;
  }
  position_.run_begins();
  run_.cause.reset();
  run_.end.reset();
  run_.turning = true;
  if (position_.has_encoder()) following_ = clock_.call_after(kFollow, [this] { follow(); });
  const Microsteps steps = run_.target - Microsteps{engine_.position()};
  engine_.forget_halt();
  set_rules(config_.homes_upwards ? steps > Microsteps{0} : steps < Microsteps{0});
  if (config_.force && steps < Microsteps{0})
    watch_force(inputs_, position_, run_.kind, config_.force->contact_from);
  // Without an encoder a known position is lost when the motor stalls, so the run ends then.
  engine_.start({steps.count(), motion_limits(config_, run_.speed),
                 pull_in_speed(config_).count() * config_.microsteps_per_mm,
                 position_.known() && !position_.has_encoder(), run_.rise});
}

void AxisDrive::end_run() {
  run_.end.reset();
  wait_.reset();
  ready_ = nullptr;
}

// Sets the switches' rules for a run. A rule that is violated already halts the run at once.
void AxisDrive::set_rules(bool towards_switch) {
  const bool at_other_end = inputs_.active(AxisInput::SecondSwitch);
  inputs_.watch_second_switch(config_.second_switch && !(at_other_end && towards_switch));
  if (run_.kind == RunKind::Seek || run_.kind == RunKind::Nudge)
    return inputs_.set_limit_rule(LimitRule::AtContact);
  if (run_.kind == RunKind::BackOff) return inputs_.set_limit_rule(LimitRule::Never);
  const Nanometers reach = config_.homes_upwards ? -kSwitchReach : kSwitchReach;
  inputs_.set_limit_rule(LimitRule::Beyond,
                         position_.screw().nearest_step(config_.switch_height + reach).count(),
                         config_.homes_upwards);
}

void AxisDrive::drop_rules() noexcept {
  inputs_.set_force_rule(ForceRule::Never);
  inputs_.set_limit_rule(LimitRule::Never);
  inputs_.watch_second_switch(false);
}

bool AxisDrive::release() {
  expects(!turning(), "the motor rests");
  if (enable_ == nullptr) return false;
  position_.forget();
  enabled_ = false;
  if (!enable_->set(false)) line_refused_ = true;
  return !line_refused_;
}

void AxisDrive::stop() {
  wanted_ = Wanted::Rest;
  if (run_.turning) return engine_.stop();
  ready_ = nullptr;
  after(Duration{0}, wiring_.stopped);
}

void AxisDrive::halt() noexcept {
  engine_.halt();
  position_.forget();
  forget();
}

void AxisDrive::forget() noexcept {
  wanted_ = Wanted::Nothing;
  run_ = {};
  drop_rules();
  wait_.reset();
  following_.reset();
  ready_ = nullptr;
}

void AxisDrive::engine_ended() {
  engine_.ended().clear();
  if (engine_.moving()) return;
  const StepEnd last = engine_.last_end();  // before anything can begin the next run
  if (ready_) return go_on();
  if (!run_.turning) return;
  run_.turning = false;
  position_.note_rest();
  following_.reset();
  drop_rules();
  run_.end = last;
  wiring_.take_changes();
  take_end();
}

void AxisDrive::go_on() {
  if (engine_.moving()) return;
  if (const auto ready = std::exchange(ready_, nullptr)) ready();
}

void AxisDrive::take_end() {
  const auto end = std::exchange(run_.end, std::nullopt);
  if (!end) return;
  if (engine_.inhibited()) return wiring_.blocked();
  const bool resisted = run_.cause && run_.cause->homing == HomingResult::Resistance;
  if (run_.cause && !resisted) return wiring_.fail(AxisFault(*run_.cause));
  if (*end == StepEnd::LineRefused) {
    line_refused_ = true;
    return wiring_.fail({.what = "the kernel refuses to set the step line, " + describe(config_.step) +
                                 ", or the direction line, " + describe(config_.direction)});
  }
  if (*end == StepEnd::Stalled) return fail_stalled();
  report_stall();
  if (wanted_ == Wanted::Nothing) return;  // a callback has aborted the motion
  if (resisted) return wiring_.resisted();
  if (wiring_.take_contact()) return;
  if (*end == StepEnd::Halted) return;  // by the limit switch's edge, which has not settled yet
  if (wanted_ == Wanted::Rest) return wiring_.stopped();
  if (*end == StepEnd::Stopped) return run_.rise ? wiring_.stopped() : run_on();
  // A copy, because the call may begin the next run.
  if (const auto then = run_.then) then();
}

void AxisDrive::fail_stalled() {
  stalls_reported_ = engine_.stalls().count;
  wiring_.fail({.what = stall_text() + "; the plate's position is unknown"});
}

// Reports a stall that did not end the run.
void AxisDrive::report_stall() {
  const std::uint64_t stalls = engine_.stalls().count;
  if (std::exchange(stalls_reported_, stalls) == stalls) return;
  wiring_.notice(stall_text() +
                 (position_.known() ? "; the encoder gives the plate's position" : "; homing continues"));
}

std::string AxisDrive::stall_text() const {
  const Stalls stalls = engine_.stalls();
  char words[200];
  std::snprintf(words, sizeof words,
                "the computer was too busy for the motor: at %.3g mm/s a step came %.4g ms late; above half "
                "the homing speed (%.3g mm/s) a motor that stops dead may lose steps",
                stalls.speed / config_.microsteps_per_mm, static_cast<double>(stalls.late.count()) / 1e6,
                config_.homing_speed.count() / 2);
  return words;
}

// Checks stalls and the encoder regularly while the motor turns.
void AxisDrive::follow() {
  report_stall();
  if (!encoder_is_believed() || !run_.turning) return;
  if (const auto off = position_.runaway()) return wiring_.fail({HomingResult::NoMovement, *off});
  following_ = clock_.call_after(kFollow, [this] { follow(); });
}

bool AxisDrive::encoder_is_believed() {
  const AxisEncoder::Finding finding = position_.check_encoder();
  if (finding.fault) {
    wiring_.fail({HomingResult::NoMovement, *finding.fault});
    return false;
  }
  if (finding.notice) wiring_.notice(*finding.notice);
  return wanted_ != Wanted::Nothing;
}

}  // namespace contourd
