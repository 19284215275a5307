#include <cmath>
#include <utility>

#include "hw/gpio/axis_words.hpp"
#include "hw/gpio/gpio_axis.hpp"

namespace contourd {
namespace {

// The encoder is looked at this often while the motor turns.
constexpr Duration kFollow{std::chrono::milliseconds{10}};
// How far behind the motor what the encoder says may be in time: its edges are counted half a millisecond
// late.
constexpr double kEncoderLag_s = 0.005;

}  // namespace

std::int64_t GpioAxis::counts() const {
  return config_.encoder->reversed ? -inputs_.encoder_count() : inputs_.encoder_count();
}

double GpioAxis::measured_plate() const {
  const double mm = (static_cast<double>(counts()) - counts_then_) / config_.encoder->counts_per_mm;
  return static_cast<double>(plate_then_) + mm * config_.microsteps_per_mm;
}

double GpioAxis::encoder_off_mm() const {
  return (measured_plate() - static_cast<double>(now_at().plate())) / config_.microsteps_per_mm;
}

void GpioAxis::begin_following() {
  if (!config_.encoder) return;
  if (!position_known_) agree();
  following_ = clock_.call_after(kFollow, [this] { follow(); });
}

void GpioAxis::agree() {
  if (!config_.encoder) return;
  counts_then_ = static_cast<double>(counts());
  plate_then_ = now_at().plate();
  plausibility_->homed();
  index_pulses_seen_ = inputs_.index_pulse().number;
}

// While the motor turns.
void GpioAxis::follow() {
  tell_stall();
  if (const auto doubt = encoder_doubt()) return fail({HomingResult::NoMovement, *doubt});
  if (!running_) return;  // who was told has aborted it
  const bool corrects = position_known_ && config_.encoder->policy == EncoderConfig::Policy::Correct;
  // While the position is unknown the screw's play is, too.
  const Nanometers play = position_known_ ? Nanometers{0} : config_.backlash;
  const Nanometers tolerance = config_.encoder->tolerance;
  const Nanometers allowed = corrects ? std::max(tolerance, config_.encoder->most_correction) : tolerance;
  const double allowed_mm =
      to_millimeters(allowed + play).count() + config_.top_speed.count() * kEncoderLag_s;
  if (std::fabs(encoder_off_mm()) > allowed_mm) return fail({HomingResult::NoMovement, difference()});
  following_ = clock_.call_after(kFollow, [this] { follow(); });
}

// That the plate is where the steps say, or what is to be done about it.
void GpioAxis::verify(std::int64_t plate, MillimetersPerSecond speed, std::function<void()> then) {
  if (!config_.encoder) return then();
  after(kEncoderRest, [this, plate, speed, then = std::move(then)] {
    if (const auto doubt = encoder_doubt()) return fail({HomingResult::NoMovement, *doubt});
    if (!moving()) return;  // who was told has aborted it
    const double off_mm = encoder_off_mm();
    if (std::fabs(off_mm) <= to_millimeters(config_.encoder->tolerance).count()) {
      plausibility_->agreed(off_mm);
      return then();
    }
    const std::string what = difference();
    if (config_.encoder->policy == EncoderConfig::Policy::Fault)
      return fail({HomingResult::NoMovement, what});
    if (const auto why = plausibility_->refusal(off_mm)) {
      return fail({HomingResult::NoMovement, what + "; " + *why});
    }
    engine_.set_position(std::llround(measured_plate()) - rest_.play);
    rest_.motor = engine_.position();
    begin_approach(plate, speed, [this, plate, speed, then] { verify(plate, speed, then); });
    disturb(Disturbance::Kind::Notice, what + "; they are made good, as " +
                                           millimeters(plausibility_->corrected_mm()) + " since homing");
  });
}

// Why the encoder cannot be relied on; nothing as a rule.
std::optional<std::string> GpioAxis::encoder_doubt() {
  if (auto edges = plausibility_->wrong_edges(inputs_.illegal_encoder_edges())) return edges;
  const AxisInputs::IndexPulse pulse = inputs_.index_pulse();
  if (!position_known_ || pulse.number == index_pulses_seen_) return std::nullopt;
  index_pulses_seen_ = pulse.number;
  const auto off = plausibility_->index_error(pulse.count);
  if (!off) return std::nullopt;
  const std::string what = "the encoder's index (" + words_of(*config_.encoder->index) +
                           ") says that its count is " +
                           millimeters(std::fabs(*off) / config_.encoder->counts_per_mm) + " off";
  if (config_.encoder->policy == EncoderConfig::Policy::Fault) return what;
  if (const auto why = plausibility_->index_refusal(*off)) return what + "; " + *why;
  counts_then_ += config_.encoder->reversed ? -*off : *off;
  disturb(Disturbance::Kind::Notice, what + "; it is put right");
  return std::nullopt;
}

std::string GpioAxis::difference() const {
  const double per_mm = config_.microsteps_per_mm;
  const auto plate = static_cast<double>(now_at().plate()), then = static_cast<double>(plate_then_);
  const double from = position_known_ ? 0 : then / per_mm;
  return "the encoder says " + millimeters(measured_plate() / per_mm - from) +
         " where the motor's steps make " + millimeters(plate / per_mm - from) +
         ": steps were lost, or the encoder does not count";
}

}  // namespace contourd
