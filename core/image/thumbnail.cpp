#include "core/image/thumbnail.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::uint64_t kLeastGrey = 255 / 6;

// Returns where the source pixels of each of `count` columns or rows begin, and where the last one's end, out
// of `size` source pixels.
std::vector<std::int32_t> edges(std::int32_t count, std::int32_t size) {
  std::vector<std::int32_t> at;
  for (std::int32_t i = 0; i <= count; ++i)
    at.push_back(static_cast<std::int32_t>(std::int64_t{i} * size / count));
  return at;
}

std::int32_t shrunk(std::int32_t side, std::int32_t longer, std::int32_t longest) {
  if (longer <= longest) return side;
  return std::max(static_cast<std::int32_t>(std::int64_t{side} * longest / longer), 1);
}

}  // namespace

Mask make_thumbnail(const Mask& mask, const PixelBox& box, Pixels longest) {
  expects(longest.count() > 0, "a thumbnail has pixels");
  expects(0 <= box.left && box.left < box.right && box.right <= mask.width().count() && 0 <= box.top &&
              box.top < box.bottom && box.bottom <= mask.height().count(),
          "the box has pixels and lies in the mask");
  const std::int32_t wide = box.right - box.left, high = box.bottom - box.top, longer = std::max(wide, high);
  const std::int32_t columns = shrunk(wide, longer, longest.count());
  const std::int32_t rows = shrunk(high, longer, longest.count());
  const std::vector<std::int32_t> x = edges(columns, wide), y = edges(rows, high);
  Mask small(Pixels{columns}, Pixels{rows});
  std::vector<std::uint32_t> sums(
      static_cast<std::size_t>(wide));  // column sums for one row of the thumbnail
  for (std::size_t row = 0; row + 1 < y.size(); ++row) {
    std::ranges::fill(sums, 0U);
    for (std::int32_t source = y[row]; source < y[row + 1]; ++source) {
      const auto pixels = mask.row(box.top + source).subspan(static_cast<std::size_t>(box.left), sums.size());
      for (std::size_t at = 0; at < sums.size(); ++at)
        sums[at] += pixels[at];
    }
    const std::span<std::uint8_t> out = small.row(static_cast<std::int32_t>(row));
    for (std::size_t column = 0; column < out.size(); ++column) {
      const std::uint64_t sum =
          std::accumulate(sums.begin() + x[column], sums.begin() + x[column + 1], std::uint64_t{0});
      if (sum == 0) continue;
      const auto count = static_cast<std::uint64_t>(y[row + 1] - y[row]) *
                         static_cast<std::uint64_t>(x[column + 1] - x[column]);
      const std::uint64_t mean = (sum + count / 2) / count;
      const bool may_vanish = count > 1;  // an unreduced pixel is copied as it is
      out[column] = static_cast<std::uint8_t>(may_vanish ? std::max(mean, kLeastGrey) : mean);
    }
  }
  return small;
}

}  // namespace contourd
