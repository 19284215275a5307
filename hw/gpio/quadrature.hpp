// Decodes an encoder's two channels, which are a quarter of a period apart: every edge of either changes the
// count by one, up while A leads B. Pure value; neither allocates nor throws.
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
    step(a_ != b_);
  }
  void edge_b(bool level) noexcept {
    if (level == b_) return skipped();
    b_ = level;
    step(a_ == b_);
  }

  [[nodiscard]] std::int64_t count() const noexcept { return count_; }
  // True if the last change of the count was upwards.
  [[nodiscard]] bool upwards() const noexcept { return upwards_; }
  // Returns the number of edges to the level that a channel already had. Before each of them an edge was
  // missed, so the count is off.
  [[nodiscard]] std::uint64_t illegal() const noexcept { return illegal_; }

 private:
  void skipped() noexcept { ++illegal_; }
  void step(bool up) noexcept {
    upwards_ = up;
    count_ += up ? 1 : -1;
  }

  bool a_ = false, b_ = false, upwards_ = true;
  std::int64_t count_ = 0;
  std::uint64_t illegal_ = 0;
};

}  // namespace contourd
