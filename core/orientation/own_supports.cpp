#include "core/orientation/own_supports.hpp"

#include <algorithm>
#include <utility>

namespace contourd {
namespace {

// A raft is at most this high.
constexpr double kRaftMm = 1.5;
// The largest section of a column, trees and braces included, and of a tip: 1 mm in diameter.
constexpr double kColumnMm2 = 20, kTipMm2 = 0.8;
// A column narrows to a tip by at least this factor, and what a tip holds is wider by at least this factor.
constexpr double kNarrows = 2, kWidens = 4;

}  // namespace

// Follows a column up to a section of this area.
void OwnSupports::widen(Column& column, double area_mm2) {
  if (column.is_tip() && area_mm2 >= kWidens * column.narrowest_mm2) {
    ++column.tips;
    column.widest_mm2 = column.narrowest_mm2 = area_mm2;
  } else if (column.is_tip() || area_mm2 <= column.widest_mm2) {
    column.narrowest_mm2 = std::min(column.narrowest_mm2, area_mm2);
  } else {
    column.widest_mm2 = column.narrowest_mm2 = area_mm2;
  }
  // What narrows again is a lattice, not something that is held.
  if (column.is_tip()) column.tips = 0;
}

bool OwnSupports::Column::is_tip() const {
  return narrowest_mm2 > 0 && narrowest_mm2 <= kTipMm2 && kNarrows * narrowest_mm2 <= widest_mm2;
}

// Lets the columns beneath meet in the parts above them.
void OwnSupports::carry_up(const MaskRuns& lit) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> meetings;  // parts of this layer and beneath
  for (std::int32_t row = 0; row < lit.rows(); ++row) {
    for_each_meeting(lit.in_row(row), beneath_.in_row(row), 0, [&](std::size_t above, std::size_t below) {
      meetings.emplace_back(parts_.part_of_run()[lit.first_in_row(row) + above],
                            part_of_run_beneath_[beneath_.first_in_row(row) + below]);
    });
  }
  std::ranges::sort(meetings);
  meetings.erase(std::unique(meetings.begin(), meetings.end()), meetings.end());
  for (Column& column : columns_)
    column.may_be = false;
  std::uint32_t last = ~0U;
  for (const auto& [above, below] : meetings) {
    Column& column = columns_[above];
    const Column& part = columns_beneath_[below];
    if (above != last) column = {.may_be = true};
    last = above;
    column.may_be = column.may_be && part.may_be;
    column.widest_mm2 = std::max(column.widest_mm2, part.widest_mm2);
    column.narrowest_mm2 = std::max(column.narrowest_mm2, part.narrowest_mm2);
    column.tips += part.tips;
    column.tips_beneath += part.may_be ? part.tips + (part.is_tip() ? 1 : 0) : 0;
  }
}

void OwnSupports::add_layer(const MaskRuns& lit) {
  if (layer_ == 0 && lit.runs().empty()) return;
  ++layer_;
  if (layer_ == 1) {
    beneath_.extract(Mask(Pixels{1}, Pixels{lit.rows()}));
    columns_beneath_.clear();
  }
  parts_.add_layer(lit, beneath_);
  const std::span<const LayerPart> parts = parts_.parts();
  columns_.assign(parts.size(), Column{});
  if (static_cast<double>(layer_) * grid_.layer_mm > kRaftMm) {
    carry_up(lit);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Column& column = columns_[i];
      const double area_mm2 = static_cast<double>(parts[i].pixels) * grid_.pixel_mm * grid_.pixel_mm;
      column.may_be = column.may_be && area_mm2 <= kColumnMm2;
      if (column.may_be) {
        widen(column, area_mm2);
      } else {
        tips_ += column.tips_beneath;
      }
    }
  }
  std::swap(columns_, columns_beneath_);
  part_of_run_beneath_.assign(parts_.part_of_run().begin(), parts_.part_of_run().end());
  beneath_ = lit;
}

}  // namespace contourd
