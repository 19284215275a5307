#include "hw/simulated_axis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

using ForceLine = SimulatedForceConfig::Line;

// The film's stiffness, the threshold of the force's line, and how often the force is computed.
constexpr double kFilmNPerMm = 5, kThresholdN = 1;
constexpr Duration kFeel{std::chrono::milliseconds{10}};

HomingResult why_ended(MoveResult result) {
  return result == MoveResult::Resistance ? HomingResult::Resistance : HomingResult::Stopped;
}

}  // namespace

SimulatedAxis::SimulatedAxis(Clock& clock, const SimulatedAxisConfig& config)
    : clock_(clock),
      config_(config),
      true_height_(config.start_height),
      force_active_(config.force && config.force->line == ForceLine::StuckActive) {}

Nanometers SimulatedAxis::nearest_step(Nanometers height) const {
  const double steps = std::round(to_millimeters(height).count() * config_.microsteps_per_mm);
  return Nanometers{std::llround(steps / config_.microsteps_per_mm * 1e6)};
}

bool SimulatedAxis::switch_closed() const {
  using Switch = SimulatedAxisConfig::Switch;
  if (config_.limit_switch == Switch::Works)
    return config_.homes_upwards ? true_height_ >= switch_height() : true_height_ <= switch_height();
  return config_.limit_switch == Switch::StuckClosed;
}

void SimulatedAxis::put_at(Nanometers true_height) {
  const bool was_closed = switch_closed();
  true_height_ = true_height;
  if (switch_closed() != was_closed) ++switch_edges_;
}

void SimulatedAxis::home(std::function<void(HomingResult)> done) {
  expects(!move_, "the axis does not move");
  const bool was_known = std::exchange(homed_, false);
  contact_ = {};
  homing_shift_.reset();
  homing_done_ = std::move(done);
  const auto slow = MillimetersPerSecond{config_.homing_speed.count() / 2};
  // The first pass runs at full speed. After backing off, the second runs at half speed and sets the
  // position.
  seek_switch(config_.homing_speed, [this, slow, was_known] {
    run(config_.homes_upwards ? -kBackOff : kBackOff, config_.homing_speed,
        [this, slow, was_known](MoveResult result) {
          if (result != MoveResult::Reached) return end_homing(why_ended(result));
          if (switch_closed()) return end_homing(HomingResult::StillClosed);
          seek_switch(slow, [this, was_known] {
            if (was_known) homing_shift_ = true_height_ - switch_height();
            true_height_ = switch_height();
            homed_ = true;
            end_homing(HomingResult::Homed);
          });
        });
  });
}

void SimulatedAxis::seek_switch(MillimetersPerSecond speed, std::function<void()> found) {
  const bool closes = config_.limit_switch != SimulatedAxisConfig::Switch::StuckOpen;
  const Nanometers whole = config_.travel + kOvertravel;
  const Nanometers distance = switch_closed()         ? Nanometers{0}
                              : closes                ? switch_height() - true_height_
                              : config_.homes_upwards ? whole
                                                      : -whole;
  run(distance, speed, [this, found = std::move(found)](MoveResult result) {
    if (result != MoveResult::Reached) return end_homing(why_ended(result));
    if (!switch_closed()) return end_homing(HomingResult::NoTrigger);
    found();
  });
}

void SimulatedAxis::move_to(Nanometers target, MillimetersPerSecond speed,
                            std::function<void(MoveResult)> done) {
  expects(!move_, "the axis does not move");
  const bool allowed = target >= Nanometers{0} && target <= config_.travel;
  if (homed_ && allowed) return run(nearest_step(target) - true_height_, speed, std::move(done));
  const MoveResult refusal = homed_ ? MoveResult::OutsideTravel : MoveResult::NotHomed;
  move_end_ = clock_.call_after(Duration{0}, [refusal, done = std::move(done)] { done(refusal); });
}

void SimulatedAxis::rise(const RisePlan& plan, std::function<void(MoveResult)> done) {
  expects(!move_, "the axis does not move");
  if (const auto refusal = why_not(plan)) {
    move_end_ = clock_.call_after(Duration{0}, [refusal, done = std::move(done)] { done(*refusal); });
    return;
  }
  const auto curve = std::make_shared<const RiseCurve>(plan, 1.0, in_mm(true_height_));
  const MotionProfile profile(*curve, config_.acceleration);
  const Nanometers end = nearest_step(plan.points.back().height);
  move_ = Move{clock_.now(), true_height_, curve, profile, std::move(done)};
  move_end_ = clock_.call_after(profile.duration(), [this, end] { finish(end, MoveResult::Reached); });
}

std::optional<MoveResult> SimulatedAxis::why_not(const RisePlan& plan) const {
  if (!homed_) return MoveResult::NotHomed;
  if (!can_follow(plan, config_.homing_speed / 2, config_.acceleration)) return MoveResult::PlanRefused;
  const Nanometers first = plan.points.front().height;
  if (first < Nanometers{0} || plan.points.back().height > config_.travel) return MoveResult::OutsideTravel;
  const double off_steps = std::fabs(in_mm(first - true_height_)) * config_.microsteps_per_mm;
  return off_steps > 1 ? std::optional(MoveResult::PlanRefused) : std::nullopt;
}

void SimulatedAxis::nudge(Nanometers distance, MillimetersPerSecond speed,
                          std::function<void(MoveResult)> done) {
  expects(!move_, "the axis does not move");
  expects(distance >= -kLongestNudge && distance <= kLongestNudge, "a nudge is short");
  move_unhomed(distance, speed, std::move(done));
}

void SimulatedAxis::raise(Nanometers distance, MillimetersPerSecond speed,
                          std::function<void(MoveResult)> done) {
  expects(!move_, "the axis does not move");
  expects(distance >= Nanometers{} && distance <= travel(), "the plate rises within its travel");
  move_unhomed(distance, speed, std::move(done));
}

void SimulatedAxis::assume_height(Nanometers height) {
  expects(!move_, "the axis does not move");
  put_at(nearest_step(height));
  homed_ = true;
}

void SimulatedAxis::move_unhomed(Nanometers distance, MillimetersPerSecond speed,
                                 std::function<void(MoveResult)> done) {
  homed_ = false;
  const bool towards_switch = (distance > Nanometers{0}) == config_.homes_upwards;
  if (towards_switch && switch_closed()) {
    move_end_ = clock_.call_after(Duration{0}, [done = std::move(done)] { done(MoveResult::AtSwitch); });
    return;
  }
  const bool closes = towards_switch && config_.limit_switch == SimulatedAxisConfig::Switch::Works;
  const Nanometers way = switch_height() - true_height_;
  if (closes) distance = config_.homes_upwards ? std::min(distance, way) : std::max(distance, way);
  run(distance, speed, [this, towards_switch, done = std::move(done)](MoveResult result) {
    done(towards_switch && switch_closed() ? MoveResult::AtSwitch : result);
  });
}

void SimulatedAxis::run(Nanometers distance, MillimetersPerSecond speed,
                        std::function<void(MoveResult)> done) {
  const std::optional<Nanometers> met = resistance(true_height_ + distance);
  const Nanometers end = met.value_or(true_height_ + distance);
  const MotionProfile profile(end - true_height_, speed, config_.acceleration);
  move_ = Move{clock_.now(), true_height_, nullptr, profile, std::move(done)};
  move_end_ = clock_.call_after(profile.duration(), [this, end, met] {
    finish(end, met ? MoveResult::Resistance : MoveResult::Reached);
  });
  feel();
}

// Returns the height at which a move down to `end` meets resistance; nullopt if nothing is in its way.
std::optional<Nanometers> SimulatedAxis::resistance(Nanometers end) {
  if (!config_.force || end >= true_height_) return std::nullopt;
  const SimulatedForceConfig& force = *config_.force;
  const bool backs_off = homing_done_ && config_.homes_upwards;
  if (backs_off) return std::nullopt;
  const Nanometers normal = homed_ ? contact_ + force.contact_from : end;
  if (force_active_ && true_height_ > normal) return true_height_;
  if (!homed_ || !force.obstruction || obstruction_met_ || peels_ < force.obstruction_after_lifts)
    return std::nullopt;
  const Nanometers met = nearest_step(contact_ + *force.obstruction);
  if (met >= true_height_ || met <= std::max(end, normal) || force.line == ForceLine::StuckInactive)
    return std::nullopt;
  obstruction_met_ = true;
  return met;
}

void SimulatedAxis::cure(double area_mm2, double perimeter_mm) {
  if (!config_.force || area_mm2 <= 0) return;
  const SimulatedForceConfig& force = *config_.force;
  if (force.part_lost_after_lifts && peels_ >= *force.part_lost_after_lifts) return;
  const double shape = std::cbrt(area_mm2 / (5 * perimeter_mm));
  stuck_ = Stuck{true_height_, area_mm2 * shape * force.peel_kpa / 1000};
}

// Computes the force at the plate's present height, and goes on while a layer may let go.
void SimulatedAxis::feel() {
  if (!config_.force) return;
  const Nanometers height = true_height();
  const double pull_n = stuck_ ? in_mm(height - stuck_->at) * kFilmNPerMm : 0;
  const bool peels = stuck_ && pull_n < stuck_->force_n;
  if (stuck_ && !peels) {
    stuck_.reset();
    ++peels_;
  }
  if (pressed_at_ && height > *pressed_at_) pressed_at_.reset();
  const bool works = config_.force->line == ForceLine::Works;
  const bool active = works ? pressed_at_ || (peels && pull_n > kThresholdN) : force_active_;
  if ((stuck_ || pressed_at_) && move_) feel_ = clock_.call_after(kFeel, [this] { feel(); });
  if (active == force_active_) return;
  force_active_ = active;
  ++force_edges_;
  // A copy, because the call may replace it.
  if (const auto call = on_force_) call({active, height_at(clock_.now())});
}

std::vector<AxisInputState> SimulatedAxis::inputs() const {
  std::vector<AxisInputState> states{{"limit switch", description(), switch_closed(), switch_edges_}};
  if (config_.force) states.push_back({kForceInput, description(), force_active_, force_edges_});
  return states;
}

Nanometers SimulatedAxis::true_height() const {
  return move_ ? move_->from + move_->profile.displacement(clock_.now() - move_->start) : true_height_;
}

void SimulatedAxis::finish(Nanometers end, MoveResult result) {
  put_at(end);
  if (result == MoveResult::Resistance) pressed_at_ = end;
  const auto done = std::move(move_->done);
  move_.reset();
  feel();
  done(result);
}

bool SimulatedAxis::release() {
  expects(!move_, "the axis does not move");
  homed_ = false;
  return true;
}

void SimulatedAxis::stop() {
  if (!move_) return;
  move_->profile.stop_at(clock_.now() - move_->start);
  const Nanometers end = nearest_step(move_->from + move_->profile.displacement(move_->profile.duration()));
  move_end_ = clock_.call_at(move_->start + move_->profile.duration(),
                             [this, end] { finish(end, MoveResult::Stopped); });
}

void SimulatedAxis::abort() noexcept {
  if (!move_) return;
  put_at(true_height());
  homed_ = false;
  move_end_.reset();
  feel_.reset();
  move_.reset();
  homing_done_ = nullptr;
}

std::optional<Nanometers> SimulatedAxis::height_at(TimePoint time) const {
  if (!homed_) return std::nullopt;
  if (!move_) return true_height_;
  return nearest_step(move_->from + move_->profile.displacement(time - move_->start));
}

}  // namespace contourd
