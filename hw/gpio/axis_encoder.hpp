// An encoder on the plate: the measured position, its difference from the position by the motor's steps, and
// the verdict on that difference. Plate positions are in microsteps. Pure value; event loop's thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/gpio/encoder_plausibility.hpp"
#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd {

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
  [[nodiscard]] double off_mm(const EncoderReading& now, std::int64_t plate_by_steps) const;
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
