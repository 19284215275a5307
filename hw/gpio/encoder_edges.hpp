// Counts the edges of an encoder's two lines in the order in which they occurred. Each line delivers only its
// own edges, so an edge is kept until no earlier edge of the other line can still arrive. An index line, if
// there is one, gives the count at which its mark is passed: always at the mark's flank above which the line
// is active, in either direction. Preallocated; neither allocates nor throws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hw/gpio/digital_line.hpp"

namespace contourd {

// Decodes an encoder's two channels, which are a quarter of a period apart: every edge of either changes the
// count by one, up while A leads B.
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

enum class EncoderLine : std::uint8_t { A, B, Index };
inline constexpr std::size_t kEncoderLines = 3;

class EncoderEdges {
 public:
  // The longest time from an edge's time stamp until its line delivers it, which a thread of the kernel does.
  static constexpr Duration kHandedOver{std::chrono::microseconds{500}};

  // The lines are not owned. Null lines mean that there is no encoder, or that it has no index.
  EncoderEdges(InputLine* a, InputLine* b, InputLine* index = nullptr) noexcept;

  // Reads the lines' edges and counts those that are old enough.
  void serve(TimePoint now) noexcept;
  // Returns when the next kept edge can be counted, or nullopt if none is kept.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  [[nodiscard]] const Quadrature& counted() const noexcept { return quadrature_; }
  // Returns the number of edges that were read, including those that are not counted yet.
  [[nodiscard]] std::uint64_t edges(EncoderLine which) const noexcept;
  // Return how often the mark was passed, and the count at the last pass.
  [[nodiscard]] std::uint64_t index_pulses() const noexcept { return index_pulses_; }
  [[nodiscard]] std::int64_t index_count() const noexcept { return index_count_; }

 private:
  struct Channel {
    InputLine* line = nullptr;
    std::array<LineEdge, 128> edges{};
    std::size_t kept = 0, counted = 0;
    std::uint64_t read_ever = 0;
    void read() noexcept;
    void drop() noexcept;
    [[nodiscard]] bool waits() const noexcept { return counted < kept; }
    [[nodiscard]] const LineEdge& first() const noexcept { return edges[counted]; }
  };
  // Returns the channel with the earliest pending edge, or null if none is pending.
  [[nodiscard]] Channel* earliest() noexcept;
  void count(const Channel& channel) noexcept;

  Channel a_, b_, mark_;
  Quadrature quadrature_;
  std::uint64_t index_pulses_ = 0;
  std::int64_t index_count_ = 0;
};

}  // namespace contourd
