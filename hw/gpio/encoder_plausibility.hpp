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
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd {

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
  [[nodiscard]] std::optional<std::string> index_refusal(double off_counts);

 private:
  [[nodiscard]] std::optional<std::string> beyond_limits(double correction_mm);

  EncoderConfig config_;
  double off_mm_ = 0;  // the difference at the last check at rest
  double corrected_in_move_mm_ = 0, corrected_mm_ = 0;
  std::uint64_t illegal_before_ = 0;
  std::optional<double> index_;  // the count at an index pulse
};

}  // namespace contourd
