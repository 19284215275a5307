#include "hw/gpio/axis_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hw/gpio/axis_text.hpp"

namespace contourd {
namespace {

// The allowed delay of the encoder's count after the motor; edges are counted half a millisecond late.
constexpr double kEncoderLag_s = 0.005;

}  // namespace

AxisEncoder::AxisEncoder(const GpioAxisConfig& axis, const EncoderConfig& encoder)
    : config_(encoder),
      steps_per_mm_(axis.microsteps_per_mm),
      backlash_(axis.backlash),
      top_speed_(axis.top_speed),
      plausibility_(config_) {}

void AxisEncoder::agree(const EncoderReading& now, std::int64_t plate) {
  agreed_count_ = static_cast<double>(now.count);
  agreed_plate_ = plate;
  plausibility_.homed();
  index_pulses_seen_ = now.index_pulses;
}

double AxisEncoder::plate(const EncoderReading& now) const {
  const double counts = static_cast<double>(now.count) - agreed_count_;
  const double up_mm = (config_.reversed ? -counts : counts) / config_.counts_per_mm;
  return static_cast<double>(agreed_plate_) + up_mm * steps_per_mm_;
}

double AxisEncoder::off_mm(const EncoderReading& now, std::int64_t plate_by_steps) const {
  return (plate(now) - static_cast<double>(plate_by_steps)) / steps_per_mm_;
}

AxisEncoder::Finding AxisEncoder::check(const EncoderReading& now, bool position_known) {
  if (auto edges = plausibility_.wrong_edges(now.illegal_edges)) return {std::move(edges), {}};
  if (!position_known || now.index_pulses == index_pulses_seen_) return {};
  index_pulses_seen_ = now.index_pulses;
  const auto off = plausibility_.index_error(now.index_count);
  if (!off) return {};
  const std::string what = "the encoder's index (" + describe(*config_.index) +
                           ") shows that its count is off by " +
                           millimeters(std::fabs(*off) / config_.counts_per_mm);
  if (!corrects()) return {what, {}};
  if (const auto why = plausibility_.index_refusal(*off)) return {what + "; " + *why, {}};
  agreed_count_ += *off;
  return {{}, what + "; the count is corrected"};
}

std::optional<std::string> AxisEncoder::runaway(const EncoderReading& now, std::int64_t plate,
                                                bool position_known) const {
  // While the position is unknown, the screw's play is unknown too.
  const Nanometers play = position_known ? Nanometers{0} : backlash_;
  const Nanometers allowed =
      position_known && corrects() ? std::max(config_.tolerance, config_.most_correction) : config_.tolerance;
  if (std::fabs(off_mm(now, plate)) <= in_mm(allowed + play) + top_speed_.count() * kEncoderLag_s)
    return std::nullopt;
  return difference(now, plate, position_known);
}

AxisEncoder::Finding AxisEncoder::compare(const EncoderReading& now, std::int64_t plate) {
  const double off = off_mm(now, plate);
  if (std::fabs(off) <= in_mm(config_.tolerance)) {
    plausibility_.agreed(off);
    return {};
  }
  const std::string what = difference(now, plate, true);
  if (!corrects()) return {what, {}};
  if (const auto why = plausibility_.refusal(off)) return {what + "; " + *why, {}};
  return {{},
          what + "; corrected by further steps, " + millimeters(plausibility_.corrected_mm()) +
              " in all since homing"};
}

std::string AxisEncoder::difference(const EncoderReading& now, std::int64_t plate_by_steps,
                                    bool position_known) const {
  const double from_mm = position_known ? 0 : static_cast<double>(agreed_plate_) / steps_per_mm_;
  return "the encoder measures " + millimeters(plate(now) / steps_per_mm_ - from_mm) +
         " but the motor's steps make " +
         millimeters(static_cast<double>(plate_by_steps) / steps_per_mm_ - from_mm) +
         ": steps were lost, or the encoder does not count";
}

}  // namespace contourd
