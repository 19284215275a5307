#include "hw/gpio/axis_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hw/gpio/axis_fault.hpp"

namespace contourd {
namespace {

// The allowed delay of the encoder's count after the motor; edges are counted half a millisecond late.
constexpr double kEncoderLag_s = 0.005;

constexpr double kCountsPerIllegalEdge = 2;

}  // namespace

void EncoderPlausibility::homed() noexcept {
  off_mm_ = corrected_in_move_mm_ = corrected_mm_ = 0;
  index_.reset();
}

void EncoderPlausibility::move_begins(std::uint64_t illegal) noexcept {
  illegal_before_ = illegal;
  corrected_in_move_mm_ = 0;
}

std::optional<std::string> EncoderPlausibility::wrong_edges(std::uint64_t illegal) const {
  const double bound =
      std::max(in_mm(config_.tolerance) * config_.counts_per_mm / kCountsPerIllegalEdge, 1.0);
  const std::uint64_t edges = illegal - illegal_before_;
  if (static_cast<double>(edges) <= bound) return std::nullopt;
  return "the encoder (" + describe(config_.a) + ", " + describe(config_.b) + ") made " +
         std::to_string(edges) +
         " impossible edges in one move: its lines are disturbed, or it is too fast, and its count may be "
         "off "
         "by more than the tolerance";
}

std::optional<std::string> EncoderPlausibility::refusal(double off_mm) {
  if (std::fabs(off_mm - off_mm_) < std::fabs(off_mm) / 2) {
    return "the difference grew over several moves, while lost steps appear in one: the encoder loses "
           "counts, "
           "or its counts_per_mm or the axis' microsteps_per_mm is wrong";
  }
  if (auto why = beyond_limits(std::fabs(off_mm))) return why;
  off_mm_ = 0;
  return std::nullopt;
}

std::optional<std::string> EncoderPlausibility::beyond_limits(double correction_mm) {
  corrected_in_move_mm_ += correction_mm;
  corrected_mm_ += correction_mm;
  if (corrected_in_move_mm_ > in_mm(config_.most_correction)) {
    return "it would need a correction of " + millimeters(corrected_in_move_mm_) + " in one move, and " +
           millimeters(in_mm(config_.most_correction)) + " are allowed";
  }
  if (corrected_mm_ > in_mm(config_.most_correction_sum)) {
    return "it would need a correction of " + millimeters(corrected_mm_) + " since homing, and " +
           millimeters(in_mm(config_.most_correction_sum)) + " are allowed";
  }
  return std::nullopt;
}

std::optional<double> EncoderPlausibility::index_error(std::int64_t count) noexcept {
  const auto at = static_cast<double>(count);
  if (!index_) {
    index_ = at;
    return std::nullopt;
  }
  const double off = std::remainder(at - *index_, in_mm(config_.index_every) * config_.counts_per_mm);
  if (std::fabs(off) <= in_mm(config_.tolerance) * config_.counts_per_mm) return std::nullopt;
  *index_ += off;
  return off;
}

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
