#include "core/mask/rasterizer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/geometry/double_pair.hpp"
#include "core/mask/exact_side.hpp"

namespace contourd {
namespace {

constexpr std::int32_t kOne = CoverageBand::kOne;
constexpr int kOneBits = CoverageBand::kOneBits;
constexpr std::uint32_t kNone = 0xFFFFFFFF;

// The smallest width for which steepness is calculated, in columns: keeps the steepness of upright sides
// finite.
constexpr double kMinWidth = 1e-6;

std::int32_t rounded(double positive) {
  return static_cast<std::int32_t>(positive + 0.5);
}

// Returns a column in whole units. The ends of a side that has been worked off are known to some 1e-12 only:
// rounding up begins a little above one half, since halves and other binary fractions are common.
std::int32_t column_in_units(double column) {
  constexpr double kOffHalf = 1.0 / 600;
  return rounded(std::max(0.0, column * kOne - kOffHalf));
}

// Rounds to the nearest whole number, halves to the even one, so that two sides with opposite directions add
// opposite numbers. The sum has no bits below 1; its last 32 bits are the number. REQUIRES: the number is
// within the range of the result.
std::int32_t rounded_evenly(double number) {
  expects_costly([=] { return std::fabs(number) < 2147483647.5; }, "the number fits into 32 bits");
  constexpr double kBitsBelowOne = 6755399441055744.0;  // 1.5 * 2^52
  return static_cast<std::int32_t>(
      static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(number + kBitsBelowOne)));
}

// Chooses without a branch, for conditions that cannot be predicted.
std::uint32_t chosen(bool first, std::uint32_t if_first, std::uint32_t if_not) {
  return if_not ^ ((if_first ^ if_not) & (0U - static_cast<std::uint32_t>(first)));
}

// True if 0 <= number <= positive_limit. Compares bits, which are ordered like positive numbers; the bits of
// a negative number are above them all. May be false for -0.
bool is_between_0_and(double positive_limit, double number) {
  return std::bit_cast<std::uint64_t>(number) <= std::bit_cast<std::uint64_t>(positive_limit);
}

// Return the point of the side at the given x, or y, clamped to the side's ends.
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
  std::int32_t cover;     // height of the piece in units; negative if the side runs upwards
  double half_steepness;  // units of height for each column, halved, with the sign of the cover
};

// Adds a piece that crosses several pixels. Everything right of the piece gets the piece's cover. In a pixel
// that the piece crosses, the part right of it counts: the mean of the piece's heights at the pixel's left
// and right edges, or a triangle if the piece begins or ends within the pixel.
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
  const double edge = column + 1.0;
  const double beyond = piece.right - edge;
  if (beyond > 1.0) return add_long_piece(row, piece);
  // One pixel or two, without a branch, since the number cannot be predicted. The middle of the piece gives
  // the area right of it up to the first pixel's edge; the triangle beyond the edge counts as negative there.
  const double cover = piece.cover;
  const double in_second = 0.5 * (beyond + std::fabs(beyond));  // 0 if negative
  const double triangle = piece.half_steepness * in_second * in_second;
  const std::int32_t first = rounded_evenly(cover * (edge - 0.5 * (piece.left + piece.right)) + triangle);
  const std::int32_t both = rounded_evenly(cover - triangle);
  row.add(static_cast<std::size_t>(column), first, both - first, piece.cover - both);
}

// Lights a run of pixels among kPixels, in vectors of them.
template <std::uint8_t kPixels>
inline void light_among(std::uint8_t* pixels, std::int32_t first, std::int32_t count) {
  std::array<std::uint8_t, kPixels> lit;
  std::memcpy(lit.data(), pixels, lit.size());
  const auto begin = static_cast<std::uint8_t>(first), length = static_cast<std::uint8_t>(count);
  for (std::uint8_t i = 0; i < kPixels; ++i)
    lit[i] |= static_cast<std::uint8_t>(i - begin) < length ? 255 : 0;
  std::memcpy(pixels, lit.data(), lit.size());
}

// Lights pixels fully in a picture that has been painted.
class FullLight {
 public:
  FullLight(Mask& mask, std::span<std::uint64_t> dark, std::span<std::uint8_t> band_lit, int band_bits)
      : mask_(mask),
        dark_(dark),
        chunks_(dark.size() / static_cast<std::size_t>(mask.height().count())),
        band_lit_(band_lit),
        band_bits_(band_bits) {}

  void light_run(std::int32_t row, std::int32_t first, std::int32_t end) const {
    std::memset(mask_.row(row).data() + first, 255, static_cast<std::size_t>(end - first));
    mark_lit({first, end, row, row + 1});
  }

  // Lights an ellipse. A support's rows are short and of different lengths: short rows are lit without a
  // branch.
  void light_ellipse(const EllipseRows& ellipse) const {
    constexpr std::int32_t kShort = 32;
    const std::int32_t rows = static_cast<std::int32_t>(ellipse.first.size()), width = mask_.width().count();
    if (rows == 0 || ellipse.left >= ellipse.right) return;
    std::uint8_t* pixels = mask_.row(ellipse.top).data();
    const std::int32_t* first = ellipse.first.data();
    const std::int32_t* end = ellipse.end.data();
    if (const std::int32_t left = ellipse.left; ellipse.right - left <= kShort && left + kShort <= width) {
      pixels += left;
      for (std::int32_t i = 0; i < rows; ++i, pixels += width)
        light_among<kShort>(pixels, first[i] - left, end[i] - first[i]);
    } else {
      for (std::int32_t i = 0; i < rows; ++i, pixels += width)
        std::memset(pixels + first[i], 255, static_cast<std::size_t>(end[i] - first[i]));
    }
    mark_lit({ellipse.left, ellipse.right, ellipse.top, ellipse.top + rows});
  }

 private:
  // An area of pixels; `right` and `bottom` are exclusive.
  struct PixelArea {
    std::int32_t left, right, top, bottom;
  };

  // Marks the area's blocks as not dark. The next picture finds them neither dark nor full, so it writes them
  // again.
  void mark_lit(const PixelArea& area) const {
    constexpr std::int32_t kBlock = CoverageBand::kBlock, kChunkBlocks = CoverageBand::kChunkBlocks;
    const std::int32_t first = area.left / kBlock, last = (area.right - 1) / kBlock;
    const std::size_t chunks = chunks_;
    for (std::int32_t chunk = first / kChunkBlocks; chunk <= last / kChunkBlocks; ++chunk) {
      const std::int32_t from = std::max(first - chunk * kChunkBlocks, 0);
      const std::int32_t to = std::min(last - chunk * kChunkBlocks, kChunkBlocks - 1);
      const std::uint64_t kept = ~((~std::uint64_t{0} >> (kChunkBlocks - 1 - to + from)) << from);
      std::uint64_t* dark =
          dark_.data() + static_cast<std::size_t>(area.top) * chunks + static_cast<std::size_t>(chunk);
      for (std::int32_t row = area.top; row < area.bottom; ++row, dark += chunks)
        *dark &= kept;
    }
    for (std::int32_t band = area.top >> band_bits_; band <= (area.bottom - 1) >> band_bits_; ++band)
      band_lit_[static_cast<std::size_t>(band)] = 1;
  }

  Mask& mask_;
  std::span<std::uint64_t> dark_;
  std::size_t chunks_;  // words a row
  std::span<std::uint8_t> band_lit_;
  int band_bits_;
};

}  // namespace

Rasterizer::Rasterizer(Pixels width, Pixels height, AntiAliasing anti_aliasing)
    : mask_(width, height),
      width_(width.count()),
      height_(height.count()),
      anti_aliasing_(anti_aliasing),
      band_(width_),
      band_bits_(std::countr_zero(static_cast<std::uint32_t>(band_.rows()))),
      shared_(width_, band_.stride(), band_.rows()),
      lit_rows_(width, height) {
  first_side_.assign(static_cast<std::size_t>((height_ - 1) >> band_bits_) + 1, kNone);
  content_.band_lit.assign(first_side_.size(), 0);
  content_.dark.assign(band_.chunks() * static_cast<std::size_t>(height_), ~std::uint64_t{0});
  content_.full.assign(content_.dark.size(), 0);
}

inline void Rasterizer::add_covered(PixelPoint from, PixelPoint to) {
  const double width = width_;
  const double height = height_;
  if (is_between_0_and(width, from.x) && is_between_0_and(height, from.y) && is_between_0_and(width, to.x) &&
      is_between_0_and(height, to.y)) {
    add_covered_within(from, to);
  } else if (std::max(from.y, to.y) > 0.0 && std::min(from.y, to.y) < height) {
    add_cut(from, to);
  }
}

// Cuts a side at the display's edges. A part left of the display changes all pixels of a row alike, as if it
// were on the edge; a part right of it, above or below changes none.
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
  const std::array corners{within(start), entry, exit, within(end)};
  for (std::size_t i = 1; i < corners.size(); ++i)
    add_covered_within(corners[i - 1], corners[i]);
}

// Adds a side within the display. REQUIRES: both ends are on the display or its edges.
[[gnu::always_inline]] inline void Rasterizer::add_covered_within(PixelPoint from, PixelPoint to) {
  expects_costly(
      [&] {
        const auto shown = [this](PixelPoint p) {
          return 0 <= p.x && p.x <= width_ && 0 <= p.y && p.y <= height_;
        };
        return shown(from) && shown(to);
      },
      "both ends are on the display");
  // Heights are whole units: where two sides meet their ends are rounded alike, so that one side continues
  // exactly where the other ends.
  const std::int32_t from_y = rounded(from.y * kOne);
  const std::int32_t to_y = rounded(to.y * kOne);
  if (from_y == to_y) {
    level_sides_.push_back({from_y, from.x, to.x});
    return;
  }
  // Numbers are chosen instead of branches taken: the direction of a side cannot be predicted.
  const auto down = static_cast<std::size_t>(from_y < to_y);
  const std::int32_t top_y = std::min(from_y, to_y);
  const double top_x = std::array{to.x, from.x}[down];
  const double height = to_y - from_y;
  const double width = to.x - from.x;
  const auto number = static_cast<std::uint32_t>(covered_sides_.size());
  covered_sides_.push_back({top_x, width / std::fabs(height),
                            0.5 * height / std::max(kMinWidth, std::fabs(width)), top_y,
                            std::max(from_y, to_y), static_cast<std::int32_t>(2 * down) - 1,
                            std::exchange(first_side_at(top_y >> kOneBits), number), top_y});
}

inline void Rasterizer::add_centers(PixelPoint from, PixelPoint to) {
  // Rows whose centre line is between the ends' y, including the upper end's. Most sides cross none.
  const std::int32_t first_row = centers_before(std::min(from.y, to.y), height_);
  const std::int32_t end_row = centers_before(std::max(from.y, to.y), height_);
  if (first_row == end_row) return;
  std::int32_t sign = 1;
  if (to.y < from.y) {
    sign = -1;
    std::swap(from, to);
  }
  std::uint32_t& first = first_side_at(first_row);
  center_sides_.push_back({from, to, (to.x - from.x) / (to.y - from.y), first_row, end_row, sign, first});
  first = static_cast<std::uint32_t>(center_sides_.size() - 1);
}

void Rasterizer::add_side(PixelPoint from, PixelPoint to) {
  if (anti_aliasing_ == AntiAliasing::On) {
    add_covered(from, to);
  } else {
    add_centers(from, to);
  }
}

void Rasterizer::add_segments(std::span<const Segment> segments, const PixelMap& map) {
  const PixelMap in_registers = map;
  if (map.turns_round()) {
    for (const Segment& segment : segments)
      add_side(in_registers.to_pixels(segment.to), in_registers.to_pixels(segment.from));
    return;
  }
  for (const Segment& segment : segments)
    add_side(in_registers.to_pixels(segment.from), in_registers.to_pixels(segment.to));
}

void Rasterizer::add_loops(const Contours& contours, const PixelMap& map) {
  const bool turned = map.turns_round();
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    PixelPoint last = map.to_pixels(points.back());
    for (const Point& point : points) {
      const PixelPoint next = map.to_pixels(point);
      if (turned) {
        add_side(next, last);
      } else {
        add_side(last, next);
      }
      last = next;
    }
  }
}

void Rasterizer::clear() {
  covered_sides_.clear();
  level_sides_.clear();
  center_sides_.clear();
  std::ranges::fill(first_side_, kNone);
}

const Mask& Rasterizer::paint() {
  MaskBudget unlimited;
  if (!paint(unlimited)) throw std::length_error("the contours cross each other too often");
  return mask_;
}

bool Rasterizer::paint(MaskBudget& budget) {
  Painted painted = Painted::Overrun;
  if (budget.can_hold(covered_sides_.size()) && budget.spend(covered_sides_.size())) {
    painted = paint_bands(budget, Overlaps::Searched);
    if (painted == Painted::ToAnOverlap) {
      begin_again();
      painted = paint_bands(budget, Overlaps::Filled);
    }
    if (painted == Painted::ToAnOverlap)
      painted = unite_sides(budget) ? paint_bands(budget, Overlaps::Gone) : Painted::Overrun;
  }
  clear();
  return painted == Painted::All;
}

void Rasterizer::light(const Contours& convex, const PixelMap& map) {
  const FullLight light(mask_, content_.dark, content_.band_lit, band_bits_);
  for (const ContourLoop& loop : convex.loops)
    lit_rows_.visit(convex.points_of(loop), map,
                    [&light](std::int32_t row, std::int32_t first, std::int32_t end) {
                      light.light_run(row, first, end);
                    });
}

void Rasterizer::light(std::span<const ConicCut> cuts, const PixelMap& map) {
  const FullLight light(mask_, content_.dark, content_.band_lit, band_bits_);
  for (const ConicCut& cut : cuts) {
    if (cut.whole) {
      light.light_ellipse(lit_rows_.ellipse(cut, map));
    } else {
      lit_rows_.visit(cut, map, [&light](std::int32_t row, std::int32_t first, std::int32_t end) {
        light.light_run(row, first, end);
      });
    }
  }
}

Rasterizer::Painted Rasterizer::paint_bands(MaskBudget& budget, Overlaps overlaps) {
  for (std::int32_t first_row = 0; first_row < height_; first_row += band_.rows()) {
    std::uint8_t& lit = content_.band_lit[static_cast<std::size_t>(first_row >> band_bits_)];
    const bool has_sides = first_side_at(first_row) != kNone;
    if (!has_sides && lit == 0) continue;
    lit = has_sides;
    if (!budget.look_at_the_clock()) return Painted::Overrun;
    if (const Painted painted = paint_band(budget, first_row, overlaps); painted != Painted::All)
      return painted;
  }
  return Painted::All;
}

Rasterizer::Painted Rasterizer::paint_band(MaskBudget& budget, std::int32_t first_row, Overlaps overlaps) {
  const std::int32_t end_row = std::min(first_row + band_.rows(), height_);
  if (anti_aliasing_ == AntiAliasing::Off) {
    work_off_center_sides(first_row, end_row);
    for (std::int32_t row = first_row; row < end_row; ++row)
      band_.paint(row - first_row, mask_.row(row), blocks_of(row));
    return Painted::All;
  }
  if (overlaps == Overlaps::Filled) {
    work_off_and_count(first_row, end_row);
    for (std::int32_t row = first_row; row < end_row; ++row)
      band_.paint_shared(row - first_row, mask_.row(row), blocks_of(row), shared_);
    return fill_shared_pixels(budget, first_row);
  }
  work_off_covered_sides(first_row, end_row, [](std::uint32_t, double) {});
  bool sound = true;
  for (std::int32_t row = first_row; row < end_row; ++row)
    sound &= band_.paint_covered(row - first_row, mask_.row(row), blocks_of(row));
  return sound || overlaps == Overlaps::Gone ? Painted::All : Painted::ToAnOverlap;
}

// Gives the shared pixels of a band that has been painted their exact grey values.
Rasterizer::Painted Rasterizer::fill_shared_pixels(MaskBudget& budget, std::int32_t first_row) {
  shared_.collect(first_row, [this](std::uint32_t number) { return unit_side(number); });
  Painted painted = shared_.too_dense() ? Painted::ToAnOverlap : Painted::All;
  for (const SharedPixels::Pixel& pixel : shared_.pixels()) {
    constexpr std::uint32_t kSidesAStep = 8;  // of the pairs of sides that may cross
    if (painted != Painted::All) break;
    if (!budget.spend(1 + pixel.sides * pixel.sides / kSidesAStep)) painted = Painted::Overrun;
    const std::optional<double> filled = shared_.filled(pixel);
    if (!filled) continue;
    // Where nothing overlaps, the sum gives the same grey value, and is the one that counts.
    const auto units = static_cast<std::int32_t>(*filled * kOne + 0.5);
    const std::int32_t sum = std::min(std::abs(static_cast<std::int32_t>(pixel.winding)), kOne);
    if (std::abs(units - sum) > kWindingSlack)
      mask_.row(pixel.row + first_row)[static_cast<std::size_t>(pixel.column)] =
          grey_of(static_cast<std::uint32_t>(units));
  }
  shared_.clear();
  return painted;
}

// Lists all sides again, from their upper ends.
void Rasterizer::begin_again() {
  std::ranges::fill(first_side_, kNone);
  for (std::uint32_t i = 0; i < covered_sides_.size(); ++i) {
    CoveredSide& side = covered_sides_[i];
    side.x += side.slope * (side.sign * (side.top_y - side.y));
    side.y = side.top_y;
    side.next = std::exchange(first_side_at(side.top_y >> kOneBits), i);
  }
  std::ranges::sort(level_sides_, {}, &LevelSide::y);
  next_level_ = 0;
}

// Works off the band's part of all sides, and counts their pieces in the pixels. Level sides are counted
// where they lie within a row; between two rows they bound nothing.
void Rasterizer::work_off_and_count(std::int32_t first_row, std::int32_t end_row) {
  constexpr std::int32_t kWithinRow = kOne - 1;
  work_off_covered_sides(first_row, end_row, [this, first_row](std::uint32_t number, double next_x) {
    const CoveredSide& side = covered_sides_[number];
    const std::int32_t next_y = std::min((side.y | kWithinRow) + 1, side.end_y);
    shared_.count({number, (side.y >> kOneBits) - first_row, column_in_units(side.x) >> kOneBits,
                   column_in_units(next_x) >> kOneBits, (side.y & kWithinRow) == 0,
                   (next_y & kWithinRow) == 0, side.sign > 0});
  });
  for (; next_level_ < level_sides_.size() && level_sides_[next_level_].y < end_row << kOneBits;
       ++next_level_) {
    const LevelSide& side = level_sides_[next_level_];
    const std::int32_t row = (side.y >> kOneBits) - first_row;
    if (row < 0 || (side.y & kWithinRow) == 0) continue;
    const auto number = static_cast<std::uint32_t>(covered_sides_.size() + next_level_);
    const std::int32_t from = column_in_units(side.from_x) >> kOneBits;
    const std::int32_t to = column_in_units(side.to_x) >> kOneBits;
    const auto [first, last] = std::minmax(from, to);
    shared_.count_level(number, row, first, last);
    band_.row(row).use(static_cast<std::size_t>(first), static_cast<std::size_t>(last));
  }
}

// Returns the side of a number, with its ends rounded to units; the level sides follow the others.
UnitSide Rasterizer::unit_side(std::uint32_t number) const {
  if (number >= covered_sides_.size()) {
    const LevelSide& level = level_sides_[number - covered_sides_.size()];
    return {column_in_units(level.from_x), level.y, column_in_units(level.to_x), level.y};
  }
  const CoveredSide& side = covered_sides_[number];
  const auto x_at = [&side](std::int32_t y) {
    return column_in_units(side.x + side.slope * (side.sign * (y - side.y)));
  };
  const UnitSide down{x_at(side.top_y), side.top_y, x_at(side.end_y), side.end_y};
  return side.sign > 0 ? down : UnitSide{down.to_x, down.to_y, down.from_x, down.from_y};
}

// Replaces the sides by the outline of the area that they wind around. If two sides of the outline still
// overlap, because a crossing was rounded, nothing more can be done.
bool Rasterizer::unite_sides(MaskBudget& budget) {
  arranged_.reset(1);
  const std::size_t count = covered_sides_.size() + level_sides_.size();
  for (std::uint32_t number = 0; number < count; ++number) {
    const UnitSide side = unit_side(number);
    arranged_.add({side.from_x, side.from_y}, {side.to_x, side.to_y}, 0);
  }
  clear();
  if (!arranged_.arrange(budget)) return false;
  const auto to_pixels = [](ArrangedSides::GridPoint p) {
    return PixelPoint{static_cast<double>(p.x) / kOne, static_cast<double>(p.y) / kOne};
  };
  for (const ArrangedSides::Side& side : arranged_.sides()) {
    const bool filled_left = side.winding_left != 0, filled_right = side.winding_left != side.turn;
    if (side.turn == 0 || filled_left == filled_right) continue;
    const PixelPoint low = to_pixels(side.low), high = to_pixels(side.high);
    add_side(filled_right ? low : high, filled_right ? high : low);
  }
  return true;
}

RowBlocks Rasterizer::blocks_of(std::int32_t row) {
  const std::size_t chunks = band_.chunks(), at = static_cast<std::size_t>(row) * chunks;
  return {std::span(content_.dark).subspan(at, chunks), std::span(content_.full).subspan(at, chunks)};
}

// Makes the pixels of convex loops dark. Dark blocks stay dark; the next picture finds a run's blocks no
// longer full, so it writes them again.
void Rasterizer::darken(const Contours& convex, const PixelMap& map) {
  constexpr std::int32_t kBlock = CoverageBand::kBlock, kChunkBlocks = CoverageBand::kChunkBlocks;
  const auto darken = [this](std::int32_t row, std::int32_t first, std::int32_t end) {
    std::fill_n(mask_.row(row).data() + first, end - first, std::uint8_t{0});
    const RowBlocks blocks = blocks_of(row);
    for (std::int32_t block = first / kBlock; block <= (end - 1) / kBlock; ++block)
      blocks.full[static_cast<std::size_t>(block / kChunkBlocks)] &=
          ~(std::uint64_t{1} << block % kChunkBlocks);
  };
  for (const ContourLoop& loop : convex.loops)
    lit_rows_.visit(convex.points_of(loop), map, darken);
}

// Adds the band's part of all sides that reach into it; the rest of a side goes to the next band's list.
// `see`: called with the number of each side's piece and the column at its lower end, before the piece is
// worked off.
template <typename See>
inline void Rasterizer::work_off_covered_sides(std::int32_t first_row, std::int32_t end_row, See&& see) {
  const std::int32_t band_end_y = end_row << kOneBits;
  // One row of one side at a time: the number of rows of a side cannot be predicted.
  for (std::uint32_t i = std::exchange(first_side_at(first_row), kNone); i != kNone;) {
    CoveredSide& side = covered_sides_[i];
    const std::uint32_t next = side.next;
    const std::int32_t next_y = std::min((side.y | (kOne - 1)) + 1, side.end_y);
    const std::int32_t cover = (next_y - side.y) * side.sign;
    const double next_x = side.x + side.slope * cover;
    see(i, next_x);
    add_piece(band_.row((side.y >> kOneBits) - first_row),
              {std::min(side.x, next_x), std::max(side.x, next_x), cover, side.half_steepness});
    side.x = next_x;
    side.y = next_y;
    if (next_y == band_end_y && next_y != side.end_y) [[unlikely]] {
      side.next = std::exchange(first_side_at(end_row), i);
      i = next;
    } else {
      i = chosen(next_y == side.end_y, next, i);
    }
  }
}

// Adds the band's part of all sides, without anti-aliasing.
void Rasterizer::work_off_center_sides(std::int32_t first_row, std::int32_t end_row) {
  for (std::uint32_t i = std::exchange(first_side_at(first_row), kNone); i != kNone;) {
    CenterSide& side = center_sides_[i];
    const std::uint32_t next = side.next;
    for (; side.row < std::min(side.end_row, end_row); ++side.row) {
      const double column = std::max(first_column(side), 0.0);
      if (column >= width_) continue;
      band_.row(side.row - first_row).add(static_cast<std::size_t>(column), side.sign * kOne);
    }
    if (side.row != side.end_row) side.next = std::exchange(first_side_at(end_row), i);
    i = next;
  }
}

// Returns the first column whose centre is not left of the side in its present row.
double Rasterizer::first_column(const CenterSide& side) {
  const double center_y = side.row + 0.5;
  const double x = side.from.x + (center_y - side.from.y) * side.slope;
  // Limit on the error of x from the roundings of its terms.
  const double rounding = 4e-15 * (1.0 + std::fabs(side.from.x) + std::fabs(side.to.x));
  const double nearest = std::floor(x);
  // If x is so near to a centre that the centre might lie on either side, side_of() decides exactly; a side
  // whose rounding is a pixel's size ends too far away for the centre to matter.
  if (std::fabs(x - 0.5 - nearest) > rounding || rounding > 0.25) return std::ceil(x - 0.5);
  return side_of(side.from, side.to, {nearest + 0.5, center_y}) <= 0 ? nearest : nearest + 1;
}

}  // namespace contourd
