#include "hw/gpio/encoder_plausibility.hpp"

#include <algorithm>
#include <cmath>

#include "hw/gpio/axis_text.hpp"

namespace contourd {
namespace {

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

std::optional<std::string> EncoderPlausibility::index_refusal(double off_counts) {
  return beyond_limits(std::fabs(off_counts) / config_.counts_per_mm);
}

}  // namespace contourd
