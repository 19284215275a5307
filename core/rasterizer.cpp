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

// Columns as whole numbers of 2^-32: the display's 16384 take 46 bits.
constexpr int kColumnBits = 32;
constexpr double kColumn = 4294967296.0;
constexpr std::int64_t kFraction = (std::int64_t{1} << kColumnBits) - 1;

// The least width for which steepness is told apart, in columns: keeps it a number for upright sides.
constexpr double kLeastWidth = 1e-6;

std::int64_t fixed_column(double x) {
  return static_cast<std::int64_t>(x * kColumn);
}

std::int32_t rounded(double positive) {
  return static_cast<std::int32_t>(positive + 0.5);
}

// What a piece of the side has passed of its cover, held to that: the column's bounds are rounded.
std::int32_t part_of(std::int32_t cover, double passed) {
  return rounded(std::min(passed, static_cast<double>(cover)));
}

// The share of a pixel that lies right of a side which passes `cover` units of its height between two columns
// whose fractions add up to `fractions` (in 2^-32): the mean of both distances to the pixel's right edge.
std::int32_t share_right_of(std::int32_t cover, std::int64_t fractions) {
  constexpr std::int64_t kHalf = std::int64_t{1} << kColumnBits;
  return cover - static_cast<std::int32_t>((cover * fractions + kHalf) >> (kColumnBits + 1));
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

// A piece of a side within one row: `cover` units of its height between the columns left and right (2^-32),
// where it rises by `steepness` a column. Each pixel that it crosses takes its part of the cover; the parts
// are differences of rounded sums and so add up.
void add_piece(const CoverageBand::Row& row, std::int64_t left, std::int64_t right, std::int32_t cover,
               double steepness, std::int32_t sign) {
  const auto add = [&](std::int64_t column, std::int32_t part, std::int64_t fractions) {
    const std::uint64_t cell = CoverageBand::cell(part, share_right_of(part, fractions));
    row.add(static_cast<std::size_t>(column), sign < 0 ? 0 - cell : cell);
  };
  std::int64_t column = left >> kColumnBits;
  const std::int64_t last = right >> kColumnBits;
  const std::int64_t fraction = left & kFraction;
  if (last - column <= 1) {
    // One pixel or two, without a branch: which of them cannot be foreseen. The second part may be nothing.
    const double in_first = static_cast<double>(kFraction + 1 - fraction) / kColumn;
    const std::int32_t first_part = part_of(cover, steepness * in_first);
    const std::int32_t part = column == last ? cover : first_part;
    add(column, part, fraction + (column == last ? right & kFraction : kFraction + 1));
    add(last, cover - part, right & kFraction);
    return;
  }
  double passed = steepness * (static_cast<double>(kFraction + 1 - fraction) / kColumn);
  std::int32_t sum = part_of(cover, passed);
  add(column, sum, fraction + kFraction + 1);
  while (++column < last) {
    passed += steepness;
    const std::int32_t next_sum = part_of(cover, passed);
    add(column, next_sum - sum, kFraction + 1);
    sum = next_sum;
  }
  add(last, cover - sum, right & kFraction);
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
  const std::int64_t from_x = fixed_column(from.x);
  const std::int64_t to_x = fixed_column(to.x);
  // Numbers are chosen, not branches: which way a side runs cannot be foreseen.
  const bool down = from_y < to_y;
  const std::int32_t top = down ? from_y : to_y;
  const std::int64_t width = down ? to_x - from_x : from_x - to_x;
  const double height = std::abs(to_y - from_y);
  const double columns = static_cast<double>(width) / kColumn;
  std::uint32_t& first = first_side_at(top >> kOneBits);
  covered_sides_.push_back({down ? from_x : to_x, down ? to_x : from_x,
                            static_cast<std::int64_t>(static_cast<double>(width) * kOne / height),
                            height / std::max(std::fabs(columns), kLeastWidth), top, down ? to_y : from_y,
                            down ? 1 : -1, first});
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
  const std::int32_t end_y = std::min(side.end_y, end_row << kOneBits);
  std::int64_t x = side.x;
  const double steepness = side.steepness;
  const std::int32_t sign = side.sign;
  CoverageBand::Row row = band_.row((side.y >> kOneBits) - first_row);
  for (std::int32_t y = side.y; y < end_y; row.step()) {
    const std::int32_t next_y = std::min((y | (kOne - 1)) + 1, end_y);
    const std::int32_t cover = next_y - y;
    std::int64_t next_x = x + side.slope;
    if (next_y == side.end_y) {
      next_x = side.end_x;
    } else if (cover != kOne) {
      next_x = x + ((side.slope * cover) >> kOneBits);
    }
    add_piece(row, std::min(x, next_x), std::max(x, next_x), cover, steepness, sign);
    x = next_x;
    y = next_y;
  }
  side.x = x;
  side.y = end_y;
  return end_y == side.end_y;
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
    band_.row(side.row - first_row)
        .add(static_cast<std::size_t>(column), CoverageBand::cell(side.sign * kOne, side.sign * kOne));
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
