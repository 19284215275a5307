// Whether what an encoder says can be believed, and how much of it may be made good by further steps: an
// encoder that loses counts must not make the plate drift. Pure value; event loop's thread only.
//
// A motor loses steps four full ones at a time, in one move: a difference from the steps that came by and by,
// over several moves, is the encoder's, or that of a scale or a screw that is described wrongly, and never
// made good. One that came at once is, within what the owner allows a move, and all moves since homing.
//
// An illegal edge is one that a channel had already: another was lost before it, and the count is two off at
// most. So many in one move that it may be off by more than the tolerance are too many.
//
// An index pulse comes at the same count, but for a multiple of what lies between two of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/gpio/gpio_axis_config.hpp"

namespace contourd {

class EncoderPlausibility {
 public:
  explicit EncoderPlausibility(const EncoderConfig& config) : config_(config) {}

  // The plate's position is known from now on: forgets what was made good, and where the index was.
  void homed() noexcept;
  // `illegal` edges so far.
  void move_begins(std::uint64_t illegal) noexcept;

  // What is wrong with the edges of this move; nothing as a rule.
  [[nodiscard]] std::optional<std::string> wrong_edges(std::uint64_t illegal) const;

  // At rest, encoder and steps agree within the tolerance, `off_mm` apart.
  void agreed(double off_mm) noexcept { off_mm_ = off_mm; }
  // At rest, they are `off_mm` apart, more than the tolerance: why that may not be made good; nothing when it
  // may, and then it counts as made good.
  [[nodiscard]] std::optional<std::string> refusal(double off_mm);
  // What was made good since homing.
  [[nodiscard]] double corrected_mm() const noexcept { return corrected_mm_; }

  // The encoder's count at an index pulse: by how many counts it is off, where that is beyond the tolerance.
  [[nodiscard]] std::optional<double> index_error(std::int64_t count) noexcept;
  // The same for a count that has been put right by the index: why that may not go on.
  [[nodiscard]] std::optional<std::string> index_refusal(double off_counts);

 private:
  [[nodiscard]] std::optional<std::string> beyond_limits(double correction_mm);

  EncoderConfig config_;
  double off_mm_ = 0;  // when it was last looked at, at rest
  double corrected_in_move_mm_ = 0, corrected_mm_ = 0;
  std::uint64_t illegal_before_ = 0;
  std::optional<double> index_;  // its count
};

}  // namespace contourd
