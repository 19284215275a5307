// An encoder on the plate: the measured position, its difference from the position by the motor's steps, and
// the verdict on that difference. Plate positions are in microsteps. Pure value; event loop's thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd {

// Decides whether an encoder is plausible, and how much may be corrected by further steps: an encoder that
// loses counts must not make the plate drift. Pure value; event loop's thread only.
//
// A motor loses four full steps at a time, within one move. So a difference that grew over several moves
// comes from the encoder, or from a wrong config of the scale or the screw, and is never corrected. A
// difference that arose in one move is corrected, within the configured limits per move and for all moves
// since homing.
//
// An illegal edge goes to the level that its channel already has: another edge was lost before it, and the
// count is off by at most two. An encoder is not plausible if a move has enough of them for the count to be
// off by more than the tolerance.
//
// An index pulse comes at the same count, up to a multiple of the distance between two pulses.
class EncoderPlausibility {
 public:
  explicit EncoderPlausibility(const EncoderConfig& config) : config_(config) {}

  // To be called when the plate's position becomes known. Forgets the corrections and the index's count.
  void homed() noexcept;
  // Begins a move; `illegal` is the number of illegal edges so far.
  void move_begins(std::uint64_t illegal) noexcept;

  // Returns a sentence if this move had too many illegal edges; `illegal` is their number so far.
  [[nodiscard]] std::optional<std::string> wrong_edges(std::uint64_t illegal) const;

  // Records that encoder and steps agree at rest; they differ by `off_mm`, which is within the tolerance.
  void agreed(double off_mm) noexcept { off_mm_ = off_mm; }
  // Takes the difference at rest, `off_mm`, which is beyond the tolerance. Returns the reason why it may not
  // be corrected; or nullopt if it may, and then counts it as corrected.
  [[nodiscard]] std::optional<std::string> refusal(double off_mm);
  // Returns the sum of the corrections since homing.
  [[nodiscard]] double corrected_mm() const noexcept { return corrected_mm_; }

  // Takes the encoder's count at an index pulse. Returns its error in counts if that is beyond the tolerance.
  [[nodiscard]] std::optional<double> index_error(std::int64_t count) noexcept;
  // Returns the reason why an error that the index found may not be corrected; or nullopt if it may, and then
  // counts it as corrected.
  [[nodiscard]] std::optional<std::string> index_refusal(double off_counts) {
    return beyond_limits(std::fabs(off_counts) / config_.counts_per_mm);
  }

 private:
  [[nodiscard]] std::optional<std::string> beyond_limits(double correction_mm);

  EncoderConfig config_;
  double off_mm_ = 0;  // the difference at the last check at rest
  double corrected_in_move_mm_ = 0, corrected_mm_ = 0;
  std::uint64_t illegal_before_ = 0;
  std::optional<double> index_;  // the count at an index pulse
};

// The counts of an encoder's lines so far.
struct EncoderReading {
  std::int64_t count = 0;  // rises while A leads B
  std::uint64_t illegal_edges = 0;
  std::uint64_t index_pulses = 0;
  std::int64_t index_count = 0;  // `count` at the last index pulse
};

class AxisEncoder {
 public:
  // The result of a check: at most one of the two is set, neither if all is well.
  struct Finding {
    std::optional<std::string> fault;   // the plate is not where the steps put it, or its position is unknown
    std::optional<std::string> notice;  // an error that was corrected or is to be corrected
  };

  AxisEncoder(const GpioAxisConfig& axis, const EncoderConfig& encoder);

  // Records that the plate is at `plate`, where the steps put it.
  void agree(const EncoderReading& now, std::int64_t plate);
  void move_begins(const EncoderReading& now) noexcept { plausibility_.move_begins(now.illegal_edges); }

  // Returns the measured position of the plate.
  [[nodiscard]] double plate(const EncoderReading& now) const;

  // Checks that the encoder is plausible: by its edges and, while the plate's position is known, by its
  // index. With the policy Correct the index corrects the count.
  [[nodiscard]] Finding check(const EncoderReading& now, bool position_known);
  // To be called while the motor turns; `plate` is the position by its steps. Returns a sentence if the
  // measured position differs by more than the encoder's delay explains.
  [[nodiscard]] std::optional<std::string> runaway(const EncoderReading& now, std::int64_t plate,
                                                   bool position_known) const;
  // Compares the positions at rest, while the position is known. A notice means that the caller is to correct
  // the difference by further steps.
  [[nodiscard]] Finding compare(const EncoderReading& now, std::int64_t plate);

 private:
  [[nodiscard]] double off_mm(const EncoderReading& now, std::int64_t plate_by_steps) const {
    return (plate(now) - static_cast<double>(plate_by_steps)) / steps_per_mm_;
  }
  [[nodiscard]] std::string difference(const EncoderReading& now, std::int64_t plate_by_steps,
                                       bool position_known) const;
  [[nodiscard]] bool corrects() const { return config_.policy == EncoderConfig::Policy::Correct; }

  EncoderConfig config_;
  double steps_per_mm_;
  Nanometers backlash_;
  MillimetersPerSecond top_speed_;
  EncoderPlausibility plausibility_;
  // The count and the position at which encoder and steps agreed.
  double agreed_count_ = 0;
  std::int64_t agreed_plate_ = 0;
  std::uint64_t index_pulses_seen_ = 0;
};

}  // namespace contourd
