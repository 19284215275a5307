#include "core/mask/shared_pixels.hpp"

#include <array>
#include <cmath>

#include "core/contract/expects.hpp"
#include "core/mask/block_painter.hpp"

namespace contourd {
namespace {

constexpr int kUnitBits = kWindingBits;
constexpr std::int32_t kUnits = 1 << kUnitBits;  // a pixel

std::int32_t column_of(double x) {
  return static_cast<std::int32_t>(std::floor(x / kUnits));
}

}  // namespace

SharedPixels::SharedPixels(std::int32_t width, std::size_t stride, std::int32_t rows)
    : width_(width), stride_(stride), counts_(stride * static_cast<std::size_t>(rows), 0) {}

void SharedPixels::look_at_block(std::int32_t row, std::size_t first_column, const std::uint32_t* cells,
                                 std::uint32_t winding) {
  constexpr std::uint32_t kEdgesOfOne = 2 * kEdge;
  // Three sides of one outline may cross each other, or form a loop, which crosses no edge. Sides that all
  // run down, or all up, do neither.
  constexpr std::uint32_t kMostUncrossed = 2 * kPiece;
  std::uint32_t* const counts = counts_of(row) + first_column;
  std::uint32_t edges = 0, pieces = 0;
  for (std::size_t i = 0; i < kBlockPixels; ++i) {
    edges = std::max(edges, counts[i] & kEdges);
    pieces = std::max(pieces, turning_pieces(counts[i]));
  }
  if (edges <= kEdgesOfOne && pieces <= kMostUncrossed) {
    std::fill_n(counts, kBlockPixels, 0U);
    return;
  }
  for (std::size_t i = 0; i < kBlockPixels; ++i) {
    winding += cells[i];
    const auto column = static_cast<std::int32_t>(first_column + i);
    const bool is_shared = (counts[i] & kEdges) > kEdgesOfOne || turning_pieces(counts[i]) > kMostUncrossed;
    counts[i] = 0;
    if (!is_shared || column >= width_) continue;
    pixels_.push_back({row, column, winding});
    counts[i] = static_cast<std::uint32_t>(pixels_.size());
  }
}

// The ends of the piece may lie a column farther, once they are rounded to units.
bool SharedPixels::is_near_shared(const Piece& piece) const {
  const std::uint32_t* const counts = counts_.data() + static_cast<std::size_t>(piece.row) * stride_;
  const std::int32_t first = std::max(piece.first - 1, 0), last = std::min(piece.last + 1, width_ - 1);
  for (std::int32_t column = first; column <= last; ++column)
    if (counts[column] != 0) return true;
  return false;
}

// Adds the parts of a side within one row to the shared pixels that they lie in.
void SharedPixels::cut(const UnitSide& side, std::int32_t row, std::int32_t mask_row) {
  if (side.from_y == side.to_y) return cut_level(side, row, mask_row);
  const bool is_down = side.from_y < side.to_y;
  const double low_x = is_down ? side.from_x : side.to_x, high_x = is_down ? side.to_x : side.from_x;
  const double low_y = std::min(side.from_y, side.to_y), high_y = std::max(side.from_y, side.to_y);
  const int sign = is_down ? 1 : -1;
  const double row_y = static_cast<double>(mask_row) * kUnits;
  const double top = std::max(low_y, row_y), bottom = std::min(high_y, row_y + kUnits);
  const double slope = (high_x - low_x) / (high_y - low_y);
  const auto x_at = [&](double y) {
    return y == high_y
               ? high_x
               : std::clamp(low_x + slope * (y - low_y), std::min(low_x, high_x), std::max(low_x, high_x));
  };
  const double bottom_x = x_at(bottom);
  double x = x_at(top), y = top;
  const std::int32_t last = column_of(bottom_x);
  const std::int32_t step = high_x < low_x ? -1 : 1;
  for (std::int32_t column = column_of(x);; column += step) {
    double next_x = bottom_x, next_y = bottom;
    if (column != last) {
      next_x = static_cast<double>(step > 0 ? column + 1 : column) * kUnits;
      next_y = std::clamp(low_y + (next_x - low_x) / slope, y, bottom);
      add_crossing(row, step > 0 ? column + 1 : column, {(next_y - row_y) / kUnits, -sign * step});
    }
    if (y < next_y) {
      const double left = static_cast<double>(column) * kUnits;
      add_side(row, column,
               {(x - left) / kUnits, (y - row_y) / kUnits, (next_y - row_y) / kUnits, slope, sign});
    }
    if (column == last) return;
    x = next_x;
    y = next_y;
  }
}

void SharedPixels::cut_level(const UnitSide& side, std::int32_t row, std::int32_t mask_row) {
  const double y = static_cast<double>(side.from_y - (mask_row << kUnitBits)) / kUnits;
  const std::int32_t from = side.from_x >> kUnitBits, to = side.to_x >> kUnitBits;
  for (std::int32_t column = std::min(from, to) + 1; column <= std::max(from, to); ++column)
    add_crossing(row, column, {y, from < to ? -1 : 1});
}

void SharedPixels::add_side(std::int32_t row, std::int32_t column, const PixelSide& side) {
  const std::uint32_t number = counts_of(row)[column];
  if (number == 0) return;
  Pixel& pixel = pixels_[number - 1];
  sides_.push_back({side, pixel.last_side});
  pixel.last_side = static_cast<std::uint32_t>(sides_.size() - 1);
  too_dense_ |= ++pixel.sides > PixelFill::kMostSides;
}

void SharedPixels::add_crossing(std::int32_t row, std::int32_t column, const EdgeCrossing& crossing) {
  const std::uint32_t number = counts_of(row)[column];
  if (number == 0) return;
  Pixel& pixel = pixels_[number - 1];
  crossings_.push_back({crossing, pixel.last_crossing});
  pixel.last_crossing = static_cast<std::uint32_t>(crossings_.size() - 1);
  too_dense_ |= ++pixel.crossings > PixelFill::kMostSides;
}

std::optional<double> SharedPixels::filled(const Pixel& pixel) {
  expects(!too_dense_, "no pixel is too dense");
  std::array<PixelSide, PixelFill::kMostSides> sides;
  std::array<EdgeCrossing, PixelFill::kMostSides> crossings;
  std::size_t count = 0;
  for (std::uint32_t i = pixel.last_side; i != kNone; i = sides_[i].next)
    sides[count++] = sides_[i].item;
  count = 0;
  for (std::uint32_t i = pixel.last_crossing; i != kNone; i = crossings_[i].next)
    crossings[count++] = crossings_[i].item;
  const double mean = static_cast<double>(static_cast<std::int32_t>(pixel.winding)) / kUnits;
  return fill_.filled(std::span(sides).first(pixel.sides), std::span(crossings).first(pixel.crossings), mean);
}

void SharedPixels::clear() {
  for (const Pixel& pixel : pixels_)
    counts_of(pixel.row)[pixel.column] = 0;
  pixels_.clear();
  sides_.clear();
  crossings_.clear();
  too_dense_ = false;
}

}  // namespace contourd
