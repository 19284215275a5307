// The edges of an encoder's two lines in the order in which they happened. Each line hands its own over, so
// an edge is kept until no earlier one of the other line can still come. Preallocated; neither allocates nor
// throws.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/quadrature.hpp"

namespace contourd {

class EncoderEdges {
 public:
  // From an edge's time stamp until its line shows it: the kernel's own thread hands it over.
  static constexpr Duration kHandedOver{std::chrono::microseconds{500}};

  // Not owned. Null: there is no encoder.
  EncoderEdges(InputLine* a, InputLine* b) noexcept;

  // Takes what the lines have and counts what is old enough.
  void serve(TimePoint now) noexcept;
  // When edges that are kept can be counted; nothing when none are.
  [[nodiscard]] std::optional<TimePoint> due() const noexcept;
  [[nodiscard]] const Quadrature& counted() const noexcept { return quadrature_; }

 private:
  struct Channel {
    InputLine* line = nullptr;
    std::array<LineEdge, 128> edges{};
    std::size_t kept = 0;
    void read() noexcept;
    void drop(std::size_t count) noexcept;
  };

  Channel a_, b_;
  Quadrature quadrature_;
};

}  // namespace contourd
