// The edges of an encoder's two lines in the order in which they happened. Each line hands its own over, so
// an edge is kept until no earlier one of the other line can still come. Preallocated; neither allocates nor
// throws. An index line, where there is one, tells at which count its mark is passed: the mark's flank that
// is active above it, whichever way it is passed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/quadrature.hpp"

namespace contourd {

enum class EncoderLine : std::uint8_t { A, B, Index };
inline constexpr std::size_t kEncoderLines = 3;

class EncoderEdges {
 public:
  // From an edge's time stamp until its line shows it: the kernel's own thread hands it over.
  static constexpr Duration kHandedOver{std::chrono::microseconds{500}};

  // Not owned. Null: there is no encoder, or it has no index.
  EncoderEdges(InputLine* a, InputLine* b, InputLine* index = nullptr) noexcept;

  // Takes what the lines have and counts what is old enough.
  void serve(TimePoint now) noexcept;
  // When edges that are kept can be counted; nothing when none are.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  [[nodiscard]] const Quadrature& counted() const noexcept { return quadrature_; }
  // That came in so far.
  [[nodiscard]] std::uint64_t edges(EncoderLine which) const noexcept;
  // How often the mark was passed, and the count at which it was last.
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
  // That with the earliest edge that waits; null when none does.
  [[nodiscard]] Channel* earliest() noexcept;
  void count(const Channel& channel) noexcept;

  Channel a_, b_, mark_;
  Quadrature quadrature_;
  std::uint64_t index_pulses_ = 0;
  std::int64_t index_count_ = 0;
};

}  // namespace contourd
