#include "core/contour/conic_cut.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/model/sine_cosine.hpp"

namespace contourd {
namespace {

// The position of u between low (0) and high (1) at each corner of one side of an outline: u moves like a
// point that runs evenly around half a circle, seen from the side.
//
// A curve that is run through evenly is off its chords by an eighth of its second derivative times the square
// of a step. For half an ellipse this is (pi / steps)^2 / 8 of its longer half axis. For a piece of an
// ellipse it is no larger a part of the piece's longer half side, since the piece's corners are closer
// together.
class CornerShares {
 public:
  static constexpr int kMostSteps = 512;
  static_assert(2 * (kMostSteps + 1) == kMostCorners);

  CornerShares() {
    for (int steps = kFinelyChosen; steps <= kMostSteps; steps += steps < kCoarse ? kFinelyChosen : steps) {
      rows_[row_of(steps)] = shares_.size();
      for (int i = 0; i <= steps; ++i) {
        const double sine = sine_cosine(90.0 * i / steps).sine;
        shares_.push_back(sine * sine);
      }
    }
  }

  // Returns the positions for a piece with this half width or half length, enough of them to keep the chord
  // error.
  [[nodiscard]] std::span<const double> of(double half_size_mm) const {
    constexpr double kPi = 3.14159265358979323846;
    const double needed = kPi * std::sqrt(half_size_mm / (8 * kChordErrorMm));
    int steps = kMostSteps;
    if (needed < kMostSteps) {
      const int whole = static_cast<int>(needed) + 1;
      steps = whole <= kCoarse ? (whole + kFinelyChosen - 1) / kFinelyChosen * kFinelyChosen
                               : static_cast<int>(std::bit_ceil(static_cast<unsigned>(whole)));
    }
    return std::span(shares_).subspan(rows_[row_of(steps)], static_cast<std::size_t>(steps) + 1);
  }

 private:
  // Steps are chosen by fours up to 64, then doubled.
  static constexpr int kFinelyChosen = 4, kCoarse = 64;

  static std::size_t row_of(int steps) {
    if (steps <= kCoarse) return static_cast<std::size_t>(steps / kFinelyChosen);
    const auto doublings =
        static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(steps / kCoarse)) - 1);
    return kCoarse / kFinelyChosen + doublings;
  }

  std::vector<double> shares_;
  std::array<std::size_t, 20> rows_{};
};

// The positions for straight sides: only the four corners.
constexpr std::array kEnds{0.0, 1.0};

}  // namespace

double ConicCut::half_width_at(double u) const {
  return std::sqrt(std::max(0.0, first.at(u) * second.at(u)));
}

double ConicCut::half_width() const {
  const double bend = first.b * second.b;
  double widest = std::max(half_width_at(low), half_width_at(high));
  if (bend < 0) {
    const double middle = -(first.a * second.b + first.b * second.a) / (2 * bend);
    widest = std::max(widest, half_width_at(std::clamp(middle, low, high)));
  }
  return widest;
}

void append_outline(const ConicCut& cut, Contours& contours) {
  static const CornerShares shares;
  const double length = cut.high - cut.low, half_width = cut.half_width();
  if (!(half_width > 0)) return;
  const bool straight = cut.first.b == 0 && cut.second.b == 0;
  const std::span<const double> corners =
      straight ? std::span<const double>(kEnds) : shares.of(std::max(length / 2, half_width));
  const auto first_point = static_cast<std::uint32_t>(contours.points.size());
  const Point across{-cut.along.y, cut.along.x};
  const std::size_t count = corners.size();
  contours.points.resize(first_point + 2 * count);
  // The lower side is filled from the front, the upper side backwards from the end.
  Point* const below = contours.points.data() + first_point;
  Point* const above = below + 2 * count - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double u = cut.low + length * corners[i], v = cut.half_width_at(u);
    const Point middle{cut.origin.x + u * cut.along.x, cut.origin.y + u * cut.along.y};
    below[i] = {middle.x - v * across.x, middle.y - v * across.y};
    *(above - i) = {middle.x + v * across.x, middle.y + v * across.y};
  }
  contours.loops.push_back({first_point, static_cast<std::uint32_t>(2 * count)});
}

}  // namespace contourd
