#include "core/analysis/void_finder.hpp"

#include <algorithm>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::uint32_t kOutside = 0;

// True if a gap shares a column with the outside pixels of `row`: a neighbouring row of the layer, or the row
// with the same number in an adjacent layer.
template <typename Gap, typename Row>
bool reaches_out(const Gap& gap, const Row& row) {
  return gap.first < row.first || gap.end > row.end;
}

// Calls meet(a, b) for each gap of `a` and each gap of `b` that share a column. Both lists are sorted from
// left to right, so one pass is enough.
template <typename Gaps, typename Meet>
void for_each_meeting(Gaps a, Gaps b, Meet&& meet) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->first < j->end && j->first < i->end) meet(*i, *j);
    // The gap that ends first meets no gap further right.
    if (i->end < j->end) {
      ++i;
    } else {
      ++j;
    }
  }
}

// Merges a void of the layer beneath into the void that continues it.
void merge_into(const MaskVoid& beneath, MaskVoid& whole) {
  whole.first_layer = std::min(whole.first_layer, beneath.first_layer);
  whole.volume += beneath.volume;
  whole.on_plate = whole.on_plate || beneath.on_plate;
  if (beneath.widest_pixels < whole.widest_pixels) return;
  if (beneath.widest_pixels == whole.widest_pixels && beneath.widest_layer >= whole.widest_layer) return;
  whole.widest_layer = beneath.widest_layer;
  whole.widest_pixels = beneath.widest_pixels;
  whole.center = beneath.center;
}

}  // namespace

std::span<const MaskVoid> VoidFinder::add_layer(const MaskRuns& solid, const Layer& layer) {
  expects(last_layer_ < 0 || solid.rows() == height_, "all masks have one size");
  height_ = solid.rows();
  std::swap(layer_, beneath_);
  find_gaps(solid);
  parents_.clear();
  const std::size_t nodes = 1 + beneath_.voids.size() + layer_.gaps.size();
  for (std::uint32_t node = 0; node < nodes; ++node)
    parents_.push_back(node);
  join_rows();
  if (last_layer_ >= 0) join_layers();
  note_areas();
  note_voids(layer);
  last_layer_ = layer.number;
  return ended_;
}

std::span<const MaskVoid> VoidFinder::end() {
  ended_.assign(layer_.voids.begin(), layer_.voids.end());
  layer_.voids.clear();
  last_layer_ = -1;
  return ended_;
}

void VoidFinder::find_gaps(const MaskRuns& solid) {
  const std::span<const PixelRun> runs = solid.runs();
  layer_.gaps.clear();
  layer_.rows.clear();
  layer_.first_row = runs.empty() ? 0 : runs.front().row;
  layer_.end_row = runs.empty() ? 0 : runs.back().row + 1;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    if (runs[i].row == runs[i - 1].row)
      layer_.gaps.push_back({runs[i].row, runs[i - 1].end, runs[i].first, kOutside});
  }
  // The gaps no longer move from here on, so spans into them stay valid.
  const std::span<Gap> gaps(layer_.gaps);
  std::size_t at = 0;
  for (std::int32_t row = layer_.first_row; row < layer_.end_row; ++row) {
    const std::span<const PixelRun> in_row = solid.in_row(row);
    const std::size_t count = in_row.empty() ? 0 : in_row.size() - 1;
    layer_.rows.push_back(
        in_row.empty() ? Row{} : Row{gaps.subspan(at, count), in_row.front().first, in_row.back().end});
    at += count;
  }
}

std::uint32_t VoidFinder::node_of(const Gap& gap) const {
  return static_cast<std::uint32_t>(1 + beneath_.voids.size() +
                                    static_cast<std::size_t>(&gap - layer_.gaps.data()));
}

std::uint32_t VoidFinder::root_of(std::uint32_t node) {
  while (parents_[node] != node) {
    parents_[node] = parents_[parents_[node]];
    node = parents_[node];
  }
  return node;
}

void VoidFinder::join(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = root_of(a), root_b = root_of(b);
  parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
}

void VoidFinder::join_rows() {
  for (std::int32_t number = layer_.first_row; number < layer_.end_row; ++number) {
    const Row here = layer_.row(number);
    if (here.gaps.empty()) continue;
    const Row above = layer_.row(number - 1), below = layer_.row(number + 1);
    for (const Gap& gap : here.gaps) {
      if (reaches_out(gap, above) || reaches_out(gap, below)) join(kOutside, node_of(gap));
    }
    for_each_meeting(above.gaps, here.gaps,
                     [this](const Gap& upper, const Gap& gap) { join(node_of(upper), node_of(gap)); });
  }
}

void VoidFinder::join_layers() {
  const std::int32_t end = std::max(layer_.end_row, beneath_.end_row);
  for (std::int32_t number = std::min(layer_.first_row, beneath_.first_row); number < end; ++number) {
    const Row here = layer_.row(number), beneath = beneath_.row(number);
    for (const Gap& gap : here.gaps) {
      if (reaches_out(gap, beneath)) join(kOutside, node_of(gap));
    }
    for (const Gap& gap : beneath.gaps) {
      if (reaches_out(gap, here)) join(kOutside, gap.void_number);
    }
    for_each_meeting(here.gaps, beneath.gaps,
                     [this](const Gap& gap, const Gap& other) { join(node_of(gap), other.void_number); });
  }
}

// Numbers the voids of this layer and sums up their pixels.
void VoidFinder::note_areas() {
  areas_.clear();
  void_of_.assign(parents_.size(), 0);
  for (Gap& gap : layer_.gaps) {
    const std::uint32_t root = root_of(node_of(gap));
    if (root == kOutside) continue;
    if (void_of_[root] == 0) {
      areas_.push_back({});
      void_of_[root] = static_cast<std::uint32_t>(areas_.size());
    }
    gap.void_number = void_of_[root];
    Area& area = areas_[gap.void_number - 1];
    const std::int64_t pixels = gap.end - gap.first;
    area.pixels += pixels;
    area.sum_x += static_cast<double>(pixels * (gap.first + gap.end)) / 2;
    area.sum_y += static_cast<double>(pixels * (2 * std::int64_t{gap.row} + 1)) / 2;
  }
}

void VoidFinder::note_voids(const Layer& layer) {
  layer_.voids.clear();
  for (const Area& area : areas_) {
    const auto pixels = static_cast<double>(area.pixels);
    layer_.voids.push_back({layer.number,
                            layer.number,
                            layer.number,
                            area.pixels,
                            {area.sum_x / pixels, area.sum_y / pixels},
                            area.pixels * layer.thickness.count(),
                            last_layer_ < 0,
                            false});
  }
  ended_.clear();
  for (std::uint32_t i = 0; i < beneath_.voids.size(); ++i) {
    const std::uint32_t root = root_of(i + 1);
    if (void_of_[root] != 0) {
      merge_into(beneath_.voids[i], layer_.voids[void_of_[root] - 1]);
    } else {
      ended_.push_back(beneath_.voids[i]);
      ended_.back().closed = root != kOutside;
    }
  }
}

}  // namespace contourd
