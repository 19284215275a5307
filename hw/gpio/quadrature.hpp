// Two channels of an encoder, a quarter of a period apart, as a count: every edge of either counts one, up
// while A leads B. Pure value; neither allocates nor throws.
#pragma once

#include <cstdint>

namespace contourd {

class Quadrature {
 public:
  Quadrature() = default;
  Quadrature(bool a, bool b) noexcept : a_(a), b_(b) {}

  void edge_a(bool level) noexcept {
    if (level == a_) return skipped();
    a_ = level;
    count_ += a_ != b_ ? 1 : -1;
  }
  void edge_b(bool level) noexcept {
    if (level == b_) return skipped();
    b_ = level;
    count_ += a_ == b_ ? 1 : -1;
  }

  [[nodiscard]] std::int64_t count() const noexcept { return count_; }
  // Edges to the level that a channel already had: as many were missed in between, and the count is off.
  [[nodiscard]] std::uint64_t illegal() const noexcept { return illegal_; }

 private:
  void skipped() noexcept { ++illegal_; }

  bool a_ = false, b_ = false;
  std::int64_t count_ = 0;
  std::uint64_t illegal_ = 0;
};

}  // namespace contourd
