#include "hw/gpio/homing.hpp"

#include <utility>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_motion.hpp"

namespace contourd {
namespace {

using Event = HomingEvent;
using Effect = HomingEffect;

// The time after debouncing until its result has reached this thread.
constexpr Duration kAcross{std::chrono::milliseconds{2}};

MillimetersPerSecond half(MillimetersPerSecond speed) {
  return MillimetersPerSecond{speed.count() / 2};
}

}  // namespace

Homing::Homing(const GpioAxisConfig& config, Wiring wiring) : config_(config), wiring_(std::move(wiring)) {}

void Homing::begin(Done done) {
  expects(!under_way(), "no homing is under way");
  done_ = std::move(done);
  take(Event::HomeWanted);
}

void Homing::contact(const InputChange& change) {
  contact_ = change;
  if (!wiring_.turning()) take_contact();
}

bool Homing::take_contact() {
  const auto contact = std::exchange(contact_, std::nullopt);
  if (!contact) return false;
  edge_ = contact->at;
  wiring_.end_run();
  take(contact->active ? Event::Contact : Event::Spike);
  return true;
}

void Homing::failed(HomingResult result) {
  failure_ = result;
  take(Event::Failed);
}

void Homing::take(Event event) {
  const HomingTransition* const row = homing_table().find(state_, event);
  if (row == nullptr) return;
  const HomingState next = state_ = row->next(state_);
  for (const Effect effect : row->done()) {
    carry_out(effect);
    if (state_ != next) return;  // the effect led to another event, which replaces the remaining effects
  }
}

void Homing::carry_out(Effect effect) {
  const Duration settled = config_.limit_switch.debounce + kAcross;
  switch (effect) {
    case Effect::ForgetPosition:
      return wiring_.forget_position();
    case Effect::GetReady:
      return wiring_.get_ready([this] { look_at_switch(); });
    case Effect::SeekFast:
      return seek(config_.travel + kOvertravel, config_.homing_speed);
    case Effect::SeekSlow:
      return seek(kBackOff + kOvertravel, half(config_.homing_speed));
    case Effect::SeekOn:
      return wiring_.run_on();
    case Effect::BackOff:
      return wiring_.run(AxisDrive::RunKind::BackOff, -kBackOff, config_.homing_speed,
                         [this] { way_over(); });
    case Effect::AwaitContact:
      return wait(settled);
    case Effect::LookAtSwitch:
      return wiring_.after(settled, [this] { look_at_switch(); });
    case Effect::TakePosition:
      return wiring_.take_position(edge_);
    case Effect::AwaitRest:
      return wait(config_.encoder ? kEncoderRest : Duration{0});
    case Effect::KnowPosition:
      return wiring_.know_position();
    case Effect::Approach:
      return wiring_.approach([this] { take(Event::Arrived); });
    case Effect::StopMotor:
      return wiring_.stop();
    case Effect::TellHomed:
      return finish(HomingResult::Homed);
    case Effect::TellNoTrigger:
      return finish(HomingResult::NoTrigger);
    case Effect::TellStillClosed:
      return finish(HomingResult::StillClosed);
    case Effect::TellStopped:
      return finish(HomingResult::Stopped);
    case Effect::TellFailed:
      return finish(failure_);
    case Effect::DropAnswer:
      contact_.reset();
      done_ = nullptr;
      return;
  }
}

void Homing::finish(HomingResult result) {
  contact_.reset();
  wiring_.forget();
  if (const auto done = std::exchange(done_, nullptr)) done(result);
}

}  // namespace contourd
