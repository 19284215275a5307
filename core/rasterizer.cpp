#include "core/rasterizer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/exact_side.hpp"

namespace contourd {
namespace {

constexpr std::int32_t kOne = CoverageBand::kOne;
constexpr int kOneBits = CoverageBand::kOneBits;
constexpr std::uint32_t kNone = 0xFFFFFFFF;

// The least width for which steepness is told apart, in columns: keeps it a number for upright sides.
constexpr double kLeastWidth = 1e-6;

std::int32_t rounded(double positive) {
  return static_cast<std::int32_t>(positive + 0.5);
}

// To the nearest whole number, halves to the even one, so that what two sides with opposite directions add is
// opposite too. REQUIRES: within the range of the result. The sum has no bits below one; its last 32 are the
// number's.
std::int32_t rounded_evenly(double number) {
  constexpr double kBitsBelowOne = 6755399441055744.0;  // 1.5 * 2^52
  return static_cast<std::int32_t>(
      static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(number + kBitsBelowOne)));
}

// A point of the side at the given x, or y, held between its ends.
double y_at(const PixelPoint& from, const PixelPoint& to, double x) {
  const double y = from.y + (x - from.x) * ((to.y - from.y) / (to.x - from.x));
  return std::clamp(y, std::min(from.y, to.y), std::max(from.y, to.y));
}
double x_at(const PixelPoint& from, const PixelPoint& to, double y) {
  const double x = from.x + (y - from.y) * ((to.x - from.x) / (to.y - from.y));
  return std::clamp(x, std::min(from.x, to.x), std::max(from.x, to.x));
}

// A piece of a side within one row, between two of its columns.
struct Piece {
  double left, right;
  std::int32_t cover;     // units of its height; negative when the side runs upwards
  double half_steepness;  // units of height for each column, halved, with the sign of the cover
};

// What lies right of the piece has its cover. Of a pixel that it crosses the part right of it counts: the
// mean of what the piece has passed at the pixel's left and right edge, or where it begins or ends within the
// pixel, a triangle.
void add_long_piece(const CoverageBand::Row& row, const Piece& piece) {
  auto column = static_cast<std::int32_t>(piece.left);
  const auto last = static_cast<std::int32_t>(piece.right);
  const double in_first = column + 1.0 - piece.left;
  const double in_last = piece.right - last;
  std::int32_t winding = rounded_evenly(piece.half_steepness * in_first * in_first);
  row.add(static_cast<std::size_t>(column), winding);
  while (++column < last) {
    const std::int32_t next = rounded_evenly(2 * piece.half_steepness * (column + 0.5 - piece.left));
    row.add(static_cast<std::size_t>(column), next - winding);
    winding = next;
  }
  const std::int32_t in_the_last = rounded_evenly(piece.cover - piece.half_steepness * in_last * in_last);
  row.add(static_cast<std::size_t>(last), in_the_last - winding, piece.cover - in_the_last, 0);
}

void add_piece(const CoverageBand::Row& row, const Piece& piece) {
  const auto column = static_cast<std::int32_t>(piece.left);
  const auto last = static_cast<std::int32_t>(piece.right);
  if (last - column > 1) return add_long_piece(row, piece);
  // One pixel or two: both are worked out and one taken, since which it is cannot be foreseen.
  const std::int32_t one = -static_cast<std::int32_t>(column == last);  // a mask
  const auto chosen = [one](std::int32_t if_one, std::int32_t if_two) {
    return if_two ^ ((if_one ^ if_two) & one);
  };
  const double edge = column + 1.0;
  const double in_first = edge - piece.left;
  const double in_second = piece.right - edge;
  const std::int32_t first = chosen(rounded_evenly(0.5 * piece.cover * (in_first - in_second)),
                                    rounded_evenly(piece.half_steepness * in_first * in_first));
  const std::int32_t second =
      chosen(piece.cover, rounded_evenly(piece.cover - piece.half_steepness * in_second * in_second));
  row.add(static_cast<std::size_t>(column), first, second - first, piece.cover - second);
}

}  // namespace

Rasterizer::Rasterizer(Pixels width, Pixels height, AntiAliasing anti_aliasing)
    : mask_(width, height),
      width_(width.count()),
      height_(height.count()),
      anti_aliasing_(anti_aliasing),
      band_(width_),
      band_bits_(std::countr_zero(static_cast<std::uint32_t>(band_.rows()))) {
  first_side_.assign(static_cast<std::size_t>((height_ - 1) >> band_bits_) + 1, kNone);
  band_lit_.assign(first_side_.size(), 0);
  dark_.assign(band_.chunks() * static_cast<std::size_t>(height_), ~std::uint64_t{0});
  full_.assign(dark_.size(), 0);
}

void Rasterizer::add_segments(std::span<const Segment> segments, const PixelMap& map) {
  for (const Segment& segment : segments)
    add_side(map.to_pixels(segment.from), map.to_pixels(segment.to));
}

void Rasterizer::add_loops(const Contours& contours, const PixelMap& map) {
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    PixelPoint last = map.to_pixels(points.back());
    for (const Point& point : points) {
      const PixelPoint next = map.to_pixels(point);
      add_side(last, next);
      last = next;
    }
  }
}

void Rasterizer::add_side(PixelPoint from, PixelPoint to) {
  if (anti_aliasing_ == AntiAliasing::On) {
    add_covered(from, to);
  } else {
    add_centers(from, to);
  }
}

void Rasterizer::add_covered(PixelPoint from, PixelPoint to) {
  const double width = width_;
  const double height = height_;
  if (std::min({from.x, from.y, to.x, to.y}) >= 0.0 && std::max(from.x, to.x) <= width &&
      std::max(from.y, to.y) <= height) {
    add_covered_within(from, to);
  } else if (std::max(from.y, to.y) > 0.0 && std::min(from.y, to.y) < height) {
    add_cut(from, to);
  }
}

// Cuts a side at the display's edges. What lies left of it changes all pixels of the row alike, as if it were
// on the edge; what lies right of it, above or below changes none.
void Rasterizer::add_cut(PixelPoint from, PixelPoint to) {
  const double width = width_;
  const double height = height_;
  const auto held = [height](PixelPoint p, PixelPoint from_there) {
    const double y = std::clamp(p.y, 0.0, height);
    return y == p.y ? p : PixelPoint{x_at(p, from_there, y), y};
  };
  const PixelPoint start = held(from, to);
  const PixelPoint end = held(to, from);
  const auto point_at = [&](double x, PixelPoint otherwise) {
    return (start.x < x) == (end.x < x) ? otherwise : PixelPoint{x, y_at(start, end, x)};
  };
  const auto within = [width](PixelPoint p) { return PixelPoint{std::clamp(p.x, 0.0, width), p.y}; };
  const PixelPoint entry = within(point_at(start.x < end.x ? 0.0 : width, start));
  const PixelPoint exit = within(point_at(start.x < end.x ? width : 0.0, end));
  add_covered_within(within(start), entry);
  add_covered_within(entry, exit);
  add_covered_within(exit, within(end));
}

// REQUIRES: both ends on the display or its edges.
void Rasterizer::add_covered_within(PixelPoint from, PixelPoint to) {
  // Heights in whole units: where two sides meet they are rounded alike, so what one side leaves the other
  // takes up.
  const std::int32_t from_y = rounded(from.y * kOne);
  const std::int32_t to_y = rounded(to.y * kOne);
  if (from_y == to_y) return;
  // Numbers are chosen, not branches: which way a side runs cannot be foreseen.
  const bool down = from_y < to_y;
  const std::int32_t sign = down ? 1 : -1;
  const double height = to_y - from_y;
  const double width = to.x - from.x;
  std::uint32_t& first = first_side_at((down ? from_y : to_y) >> kOneBits);
  covered_sides_.push_back({down ? from.x : to.x, width / height,
                            0.5 * height / std::max(std::fabs(width), kLeastWidth), down ? from_y : to_y,
                            down ? to_y : from_y, sign, first});
  first = static_cast<std::uint32_t>(covered_sides_.size() - 1);
}

void Rasterizer::add_centers(PixelPoint from, PixelPoint to) {
  std::int32_t sign = 1;
  if (to.y < from.y) {
    sign = -1;
    std::swap(from, to);
  }
  // Rows whose centre line y lies in [from.y, to.y).
  const double height = height_;
  const auto first_row = static_cast<std::int32_t>(std::ceil(std::clamp(from.y - 0.5, 0.0, height)));
  const auto end_row = static_cast<std::int32_t>(std::ceil(std::clamp(to.y - 0.5, 0.0, height)));
  if (first_row == end_row) return;
  std::uint32_t& first = first_side_at(first_row);
  center_sides_.push_back({from, to, (to.x - from.x) / (to.y - from.y), first_row, end_row, sign, first});
  first = static_cast<std::uint32_t>(center_sides_.size() - 1);
}

inline bool Rasterizer::work_off_in_band(CoveredSide& side, std::int32_t first_row, std::int32_t end_row) {
  const CoveredSide s = side;
  const std::int32_t end_y = std::min(s.end_y, end_row << kOneBits);
  CoverageBand::Row row = band_.row((s.y >> kOneBits) - first_row);
  double x = s.x;
  for (std::int32_t y = s.y; y < end_y; row.step()) {
    const std::int32_t next_y = std::min((y | (kOne - 1)) + 1, end_y);
    const std::int32_t cover = next_y - y;
    const double next_x = x + s.slope * cover;
    add_piece(row, {std::min(x, next_x), std::max(x, next_x), cover * s.sign, s.half_steepness});
    x = next_x;
    y = next_y;
  }
  side.x = x;
  side.y = end_y;
  return end_y == s.end_y;
}

const Mask& Rasterizer::paint() {
  for (std::int32_t first_row = 0; first_row < height_; first_row += band_.rows()) {
    std::uint8_t& lit = band_lit_[static_cast<std::size_t>(first_row >> band_bits_)];
    const bool has_sides = first_side_at(first_row) != kNone;
    if (!has_sides && lit == 0) continue;
    lit = has_sides;
    paint_band(first_row);
  }
  covered_sides_.clear();
  center_sides_.clear();
  return mask_;
}

void Rasterizer::paint_band(std::int32_t first_row) {
  work_off(covered_sides_, first_row);
  work_off(center_sides_, first_row);
  const std::size_t chunks = band_.chunks();
  const std::int32_t end_row = std::min(first_row + band_.rows(), height_);
  for (std::int32_t row = first_row; row < end_row; ++row) {
    const std::size_t at = static_cast<std::size_t>(row) * chunks;
    band_.paint(row - first_row, mask_.row(row),
                {std::span(dark_).subspan(at, chunks), std::span(full_).subspan(at, chunks)});
  }
}

// Adds the band's part of all sides that reach into it; what is left of a side goes to the next band's list.
template <typename Side>
void Rasterizer::work_off(std::vector<Side>& sides, std::int32_t first_row) {
  if (sides.empty()) return;
  const std::int32_t end_row = std::min(first_row + band_.rows(), height_);
  for (std::uint32_t i = std::exchange(first_side_at(first_row), kNone); i != kNone;) {
    Side& side = sides[i];
    const std::uint32_t next = side.next;
    if (!work_off_in_band(side, first_row, end_row)) side.next = std::exchange(first_side_at(end_row), i);
    i = next;
  }
}

bool Rasterizer::work_off_in_band(CenterSide& side, std::int32_t first_row, std::int32_t end_row) {
  for (; side.row < std::min(side.end_row, end_row); ++side.row) {
    const double column = std::max(first_column(side), 0.0);
    if (column >= width_) continue;
    band_.row(side.row - first_row).add(static_cast<std::size_t>(column), side.sign * kOne);
  }
  return side.row == side.end_row;
}

// The first column whose centre is not left of the side in its present row.
double Rasterizer::first_column(const CenterSide& side) {
  const double center_y = side.row + 0.5;
  const double x = side.from.x + (center_y - side.from.y) * side.slope;
  // How far x may be off by the roundings of what it is made from.
  const double rounding = 4e-15 * (1.0 + std::fabs(side.from.x) + std::fabs(side.to.x));
  const double nearest = std::floor(x);
  // Where x is so near to a centre that it might lie on either side, the side itself is asked; one whose
  // rounding is a pixel's size ends too far away for that to mean anything.
  if (std::fabs(x - 0.5 - nearest) > rounding || rounding > 0.25) return std::ceil(x - 0.5);
  return side_of(side.from, side.to, {nearest + 0.5, center_y}) <= 0 ? nearest : nearest + 1;
}

}  // namespace contourd
