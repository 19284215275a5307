#include "core/hollow/wall_distance.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

std::int32_t whole_root(std::int32_t square) {
  auto root = static_cast<std::int32_t>(std::sqrt(static_cast<double>(square)));
  while (root * root > square)
    --root;
  return root;
}

// Returns the first column from which on a parabola is lower than an earlier one, to the left of it.
std::int32_t first_lower(std::int32_t column, std::int32_t height, std::int32_t earlier,
                         std::int32_t earlier_height) {
  const std::int32_t dividend = column * column + height - earlier * earlier - earlier_height;
  const std::int32_t divisor = 2 * (column - earlier);
  const std::int32_t quotient = dividend / divisor;
  const bool below = dividend < 0 && quotient * divisor != dividend;
  return quotient - (below ? 1 : 0) + 1;
}

}  // namespace

WallDistance::WallDistance(const SolidColumns& columns, const CavityGrid& grid, Millimeters wall)
    : columns_(columns), width_(grid.columns), height_(grid.rows) {
  const double cells = wall.count() / grid.cell_mm;
  expects(cells <= kThickestCells, "the wall has at most kThickestCells cells");
  most_squared_ = static_cast<std::int32_t>(std::ceil((cells + 0.5) * (cells + 0.5))) - 1;
  farthest_ = whole_root(most_squared_);
  for (std::int32_t squared = 0; squared <= most_squared_; ++squared)
    reach_of_.push_back(static_cast<std::int16_t>(whole_root(most_squared_ - squared)));
  const std::size_t places = grid.cells_in_slice();
  next_end_.resize(places);
  up_or_down_.resize(places);
  reach_.resize(places);
  within_.resize(places);
  running_.resize(static_cast<std::size_t>(width_));
  envelope_.reserve(static_cast<std::size_t>(width_));
}

std::span<const std::uint8_t> WallDistance::next() {
  ++slice_;
  if (!measure_columns()) return {};
  for (std::int32_t row = 0; row < height_; ++row)
    measure_row(row);
  std::ranges::fill(running_, std::int16_t{-1});
  std::ranges::fill(within_, std::uint8_t{0});
  for (std::int32_t row = 0; row < height_; ++row)
    spread(row);
  std::ranges::fill(running_, std::int16_t{-1});
  for (std::int32_t row = height_ - 1; row >= 0; --row)
    spread(row);
  return within_;
}

// Measures the distances along z; false if none is greater than the wall.
bool WallDistance::measure_columns() {
  bool any = false;
  for (std::size_t place = 0; place < up_or_down_.size(); ++place) {
    const std::span<const std::uint16_t> ends = columns_.ends(place);
    std::uint32_t& next = next_end_[place];
    while (next < ends.size() && ends[next] <= slice_)
      ++next;
    std::int32_t distance = 0;
    // An odd number of ends below: the cell is solid, between that end and the next.
    if (next % 2 == 1) distance = std::min(slice_ - ends[next - 1] + 1, ends[next] - slice_);
    any = any || distance > farthest_;
    up_or_down_[place] = static_cast<std::uint8_t>(std::min(distance, farthest_ + 1));
  }
  return any;
}

void WallDistance::measure_row(std::int32_t row) {
  const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
  envelope_.clear();
  for (std::int32_t column = 0; column < width_; ++column) {
    const std::int32_t up = up_or_down_[first + static_cast<std::size_t>(column)];
    if (up > farthest_) continue;
    const std::int32_t height = up * up;
    std::int32_t from = 0;
    while (!envelope_.empty()) {
      const Parabola& last = envelope_.back();
      from = first_lower(column, height, last.column, last.height);
      if (from > last.from) break;
      envelope_.pop_back();
      from = 0;
    }
    if (from < width_) envelope_.push_back({from, column, height});
  }
  auto reach = reach_.begin() + static_cast<std::ptrdiff_t>(first);
  std::fill_n(reach, width_, std::int16_t{-1});
  for (std::size_t i = 0; i < envelope_.size(); ++i) {
    const Parabola& lowest = envelope_[i];
    const std::int32_t end = i + 1 < envelope_.size() ? envelope_[i + 1].from : width_;
    for (std::int32_t column = std::max(lowest.from, lowest.column - farthest_);
         column < std::min(end, lowest.column + farthest_ + 1); ++column) {
      const std::int32_t away = column - lowest.column, squared = away * away + lowest.height;
      if (squared <= most_squared_) reach[column] = reach_of_[static_cast<std::size_t>(squared)];
    }
  }
}

void WallDistance::spread(std::int32_t row) {
  const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
  const std::span reach = std::span(reach_).subspan(first, running_.size());
  const std::span within = std::span(within_).subspan(first, running_.size());
  for (std::size_t column = 0; column < running_.size(); ++column) {
    const auto passed = static_cast<std::int16_t>(running_[column] - (running_[column] >= 0 ? 1 : 0));
    running_[column] = std::max(passed, reach[column]);
    within[column] =
        static_cast<std::uint8_t>(within[column] | static_cast<std::uint8_t>(running_[column] >= 0));
  }
}

}  // namespace contourd
