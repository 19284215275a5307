#include "core/rasterizer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/exact_side.hpp"

namespace contourd {
namespace {

constexpr std::size_t kWordBits = 64;

std::size_t index_of(std::int32_t row, std::int32_t column, std::size_t per_row) {
  return static_cast<std::size_t>(row) * per_row + static_cast<std::size_t>(column);
}

}  // namespace

Rasterizer::Rasterizer(Pixels width, Pixels height, AntiAliasing anti_aliasing)
    : width_(width.count()), height_(height.count()), anti_aliasing_(anti_aliasing) {
  const Mask checks_the_size(width, height);
  words_per_row_ = (static_cast<std::size_t>(width_) + kWordBits - 1) / kWordBits;
  deltas_.assign(checks_the_size.pixels().size(), 0);
  touched_.assign(words_per_row_ * static_cast<std::size_t>(height_), 0);
  row_used_.assign(static_cast<std::size_t>(height_), 0);
}

void Rasterizer::add_side(PixelPoint from, PixelPoint to) {
  if (anti_aliasing_ == AntiAliasing::On) {
    add_covered(from, to);
  } else {
    add_centers(from, to);
  }
}

void Rasterizer::add_covered(PixelPoint from, PixelPoint to) {
  // Heights in whole units: where two sides meet they are rounded alike, so what one side leaves the other
  // takes up.
  const auto fixed = [this](double y) {
    return static_cast<std::int32_t>(
        std::floor(std::clamp(y, 0.0, static_cast<double>(height_)) * kOne + 0.5));
  };
  std::int32_t top = fixed(from.y);
  std::int32_t bottom = fixed(to.y);
  if (top == bottom) return;
  const std::int32_t sign = top < bottom ? 1 : -1;
  if (sign < 0) {
    std::swap(from, to);
    std::swap(top, bottom);
  }
  const double dx_dy = (to.x - from.x) / (to.y - from.y);
  const auto x_at = [&](std::int32_t y) {
    // Held between the side's ends, which rounded heights could step beyond.
    const double x = from.x + (static_cast<double>(y) / kOne - from.y) * dx_dy;
    return std::clamp(x, std::min(from.x, to.x), std::max(from.x, to.x));
  };
  double x = x_at(top);
  for (std::int32_t y = top; y < bottom;) {
    const std::int32_t row = y >> kOneBits;
    const std::int32_t next_y = std::min((row + 1) << kOneBits, bottom);
    const double next_x = x_at(next_y);
    add_row_cover(row, std::min(x, next_x), std::max(x, next_x), next_y - y, sign);
    x = next_x;
    y = next_y;
  }
}

// A side that passes `cover` units of a row's height between x = left and x = right. Right of it the winding
// number is `sign` times cover larger; within [left, right] it grows linearly. A pixel's share is the mean
// over the pixel.
void Rasterizer::add_row_cover(std::int32_t row, double left, double right, std::int32_t cover,
                               std::int32_t sign) {
  if (left >= width_) return;
  if (left < 0.0 || right > width_) {
    // What lies left of the display changes all pixels of the row alike; what lies right of it changes none.
    const double cover_per_pixel = right > left ? cover / (right - left) : 0.0;
    const auto rounded = [](double units) { return static_cast<std::int32_t>(units + 0.5); };
    const std::int32_t beyond_left = right <= 0.0 ? cover : rounded(cover_per_pixel * std::max(-left, 0.0));
    if (beyond_left != 0) add_delta(row, 0, sign * beyond_left);
    if (right <= 0.0) return;
    cover = right <= width_ ? cover - beyond_left : rounded(cover_per_pixel * (width_ - std::max(left, 0.0)));
    left = std::max(left, 0.0);
    right = std::min(right, static_cast<double>(width_));
  }
  const double width = right - left;
  // The integral of the growing cover from left to x.
  const auto integral = [=](double x) {
    if (x <= left) return 0.0;
    if (x >= right) return cover * (x - (left + right) / 2);
    return cover * (x - left) * (x - left) / (2 * width);
  };
  const auto first = static_cast<std::int32_t>(left);
  const auto last = std::min(static_cast<std::int32_t>(right), width_ - 1);
  std::int32_t share = 0;
  double passed = 0.0;
  for (std::int32_t column = first; column <= last; ++column) {
    const double next = integral(column + 1.0);
    const auto next_share = static_cast<std::int32_t>(next - passed + 0.5);
    add_delta(row, column, sign * (next_share - share));
    share = next_share;
    passed = next;
  }
  if (last + 1 < width_) add_delta(row, last + 1, sign * (cover - share));
}

void Rasterizer::add_centers(PixelPoint from, PixelPoint to) {
  const std::int32_t sign = from.y < to.y ? 1 : -1;
  if (sign < 0) std::swap(from, to);
  // Rows whose centre line y lies in [from.y, to.y).
  const auto first_row =
      static_cast<std::int32_t>(std::ceil(std::clamp(from.y - 0.5, 0.0, static_cast<double>(height_))));
  const auto end_row =
      static_cast<std::int32_t>(std::ceil(std::clamp(to.y - 0.5, 0.0, static_cast<double>(height_))));
  const double dx_dy = (to.x - from.x) / (to.y - from.y);
  // How far x may be off by the roundings of what it is made from.
  const double rounding = 4e-15 * (1.0 + std::fabs(from.x) + std::fabs(to.x));
  std::int32_t row = first_row;
  // The first column whose centre is not left of x. Where x is so near to a centre that it might lie on
  // either side, the side itself is asked; one whose rounding is a pixel's size ends too far away for that to
  // mean anything.
  const auto first_column_from = [&](double x) {
    const double nearest = std::floor(x);
    if (std::fabs(x - 0.5 - nearest) > rounding || rounding > 0.25) return std::ceil(x - 0.5);
    return side_of(from, to, {nearest + 0.5, row + 0.5}) <= 0 ? nearest : nearest + 1;
  };
  for (; row < end_row; ++row) {
    const double x = from.x + (row + 0.5 - from.y) * dx_dy;
    const double column = std::max(first_column_from(x), 0.0);
    if (column < width_) add_delta(row, static_cast<std::int32_t>(column), sign * kOne);
  }
}

void Rasterizer::add_delta(std::int32_t row, std::int32_t column, std::int32_t delta) {
  std::int32_t& at = deltas_[index_of(row, column, static_cast<std::size_t>(width_))];
  // Unsigned: wraps instead of overflowing when more polygons overlap than the sums can hold.
  at = static_cast<std::int32_t>(static_cast<std::uint32_t>(at) + static_cast<std::uint32_t>(delta));
  const auto bit = static_cast<std::size_t>(column);
  touched_[static_cast<std::size_t>(row) * words_per_row_ + bit / kWordBits] |= std::uint64_t{1}
                                                                                << bit % kWordBits;
  row_used_[static_cast<std::size_t>(row)] = 1;
}

void Rasterizer::paint(Mask& mask) {
  for (std::int32_t row = 0; row < height_; ++row) {
    const std::span<std::uint8_t> pixels = mask.row(row);
    std::uint8_t& used = row_used_[static_cast<std::size_t>(row)];
    if (used != 0) {
      paint_row(row, pixels);
      used = 0;
    } else {
      std::memset(pixels.data(), 0, pixels.size());
    }
  }
}

void Rasterizer::paint_row(std::int32_t row, std::span<std::uint8_t> pixels) {
  std::int32_t* const deltas = deltas_.data() + index_of(row, 0, static_cast<std::size_t>(width_));
  std::uint64_t* const touched = touched_.data() + static_cast<std::size_t>(row) * words_per_row_;
  std::uint32_t winding = 0;
  std::uint8_t grey = 0;
  std::size_t filled = 0;
  for (std::size_t word = 0; word < words_per_row_; ++word) {
    for (std::uint64_t bits = std::exchange(touched[word], 0); bits != 0; bits &= bits - 1) {
      const std::size_t column = word * kWordBits + static_cast<std::size_t>(std::countr_zero(bits));
      std::memset(pixels.data() + filled, grey, column - filled);
      filled = column;
      winding += static_cast<std::uint32_t>(std::exchange(deltas[column], 0));
      const auto magnitude =
          static_cast<std::uint32_t>(std::abs(static_cast<std::int64_t>(static_cast<std::int32_t>(winding))));
      grey =
          static_cast<std::uint8_t>((std::min<std::uint32_t>(magnitude, kOne) * 255U + kOne / 2) >> kOneBits);
    }
  }
  std::memset(pixels.data() + filled, grey, pixels.size() - filled);
}

}  // namespace contourd
