// What an encoder on the plate says beside the motor's steps: where the plate is, how far that is from where
// the steps put it, and what is to be made of the difference. Plate positions are in microsteps. Pure value;
// event loop's thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/gpio/encoder_plausibility.hpp"
#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd {

// What has been counted of its lines so far.
struct EncoderReading {
  std::int64_t count = 0;  // up while A leads B
  std::uint64_t illegal_edges = 0;
  std::uint64_t index_pulses = 0;
  std::int64_t index_count = 0;  // at the last of them
};

class AxisEncoder {
 public:
  // At most one of them; neither when all is as it should be.
  struct Finding {
    std::optional<std::string> fault;   // the plate is not where the steps say, or nobody knows
    std::optional<std::string> notice;  // that was put right, or is to be
  };

  // `encoder` is that of the axis.
  AxisEncoder(const GpioAxisConfig& axis, const EncoderConfig& encoder);

  // The steps put the plate at `plate`, and it is there.
  void agree(const EncoderReading& now, std::int64_t plate);
  void move_begins(const EncoderReading& now) noexcept { plausibility_.move_begins(now.illegal_edges); }

  // Where the plate is.
  [[nodiscard]] double plate(const EncoderReading& now) const;

  // Whether it can be believed: by its edges and, while the plate's position is known, by its index, which
  // puts the count right where that is the policy.
  [[nodiscard]] Finding check(const EncoderReading& now, bool position_known);
  // While the motor turns, `plate` being where its steps put the plate: that it is elsewhere, and not only
  // late; nothing as a rule.
  [[nodiscard]] std::optional<std::string> runaway(const EncoderReading& now, std::int64_t plate,
                                                   bool position_known) const;
  // The same at rest, the position being known. A notice: what is missing is to be made good.
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
  // Where the encoder and the steps agreed.
  double agreed_count_ = 0;
  std::int64_t agreed_plate_ = 0;
  std::uint64_t index_pulses_seen_ = 0;
};

}  // namespace contourd
