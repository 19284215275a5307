#include <utility>

#include "hw/gpio/gpio_axis.hpp"
#include "hw/homing_distances.hpp"

namespace contourd {
namespace {

// After the debouncing, until its result has come across.
constexpr Duration kAcross{std::chrono::milliseconds{2}};

}  // namespace

void GpioAxis::home(std::function<void(HomingResult)> done) {
  homing_done_ = std::move(done);
  stop_wanted_ = false;
  position_known_ = false;
  const MillimetersPerSecond fast = config_.homing_speed, slow{fast.count() / 2};
  when_ready([this, fast, slow] {
    seek(fast, screw_.nearest_step(config_.travel + kOvertravel), [this, slow](std::optional<TimePoint>) {
      back_off([this, slow] {
        seek(slow, screw_.nearest_step(kBackOff + kOvertravel), [this](std::optional<TimePoint> edge) {
          take_position(edge.value());  // it was open before: there was an edge
        });
      });
    });
  });
}

void GpioAxis::seek(MillimetersPerSecond speed, std::int64_t steps,
                    std::function<void(std::optional<TimePoint>)> found) {
  if (inputs_.active(AxisInput::LimitSwitch)) return found(std::nullopt);
  seek_ = Seek{engine_.position() + steps * towards_switch(), speed, std::move(found), std::nullopt};
  seek_further();
}

void GpioAxis::seek_further() {
  seek_->contact.reset();
  run(Way::Seek, seek_->last - engine_.position(), seek_->speed, [this] {
    // The whole way; unless the switch closed with the last step, and has yet to settle.
    after(config_.limit_switch.debounce + kAcross, [this] { end_homing(HomingResult::NoTrigger); });
  });
}

// Halted by the first edge; once it has settled, it was the switch or a disturbance on the line.
void GpioAxis::seek_on() {
  if (!seek_ || !seek_->contact) return;
  wait_.reset();
  end_.reset();
  if (stop_wanted_) return end_stopped();
  if (!seek_->contact->active) return seek_further();
  const Seek seek = std::move(*seek_);
  seek_.reset();
  seek.found(seek.contact->at);
}

void GpioAxis::back_off(std::function<void()> then) {
  const std::int64_t steps = -towards_switch() * screw_.nearest_step(kBackOff);
  run(Way::BackOff, steps, config_.homing_speed, [this, then = std::move(then)] {
    after(config_.limit_switch.debounce + kAcross, [this, then] {
      if (inputs_.active(AxisInput::LimitSwitch)) return end_homing(HomingResult::StillClosed);
      then();
    });
  });
}

// The motor has run on a little since the edge, so the plate is as many steps from the switch's height.
void GpioAxis::take_position(TimePoint edge) {
  const std::int64_t beyond = engine_.position() - engine_.position_at(edge);
  const std::int64_t play = config_.homes_upwards ? 0 : screw_.backlash();
  engine_.set_position(screw_.nearest_step(config_.switch_height) - play + beyond);
  rest_ = {engine_.position(), play};
  after(config_.encoder ? kEncoderRest : Duration{0}, [this] {
    agree();
    position_known_ = true;
    approach(screw_.nearest_step(config_.switch_height), config_.homing_speed,
             [this] { end_homing(HomingResult::Homed); });
  });
}

}  // namespace contourd
