#include "core/analysis/island_finder.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {

std::span<const MaskIsland> IslandFinder::find(const Layer& layer, const Layer& beneath,
                                               std::int64_t contact_pixels) {
  for (const MaskRuns* runs_of : {&layer.bright, &beneath.bright})
    expects(runs_of->rows() == layer.lit.rows(), "all masks have one size");
  const auto runs = static_cast<std::uint32_t>(layer.lit.runs().size());
  groups_.clear();
  for (std::uint32_t run = 0; run < runs; ++run)
    groups_.push_back({run, 0, 0});
  for (std::int32_t row = 0; row < layer.lit.rows(); ++row) {
    if (layer.lit.in_row(row).empty()) continue;
    if (row > 0) join_rows(layer.lit, row);
    count_row(layer.lit, layer.bright, row, &Group::bright);
    count_row(layer.lit, beneath.bright, row, &Group::contact);
  }
  collect(layer.lit, contact_pixels);
  return islands_;
}

std::uint32_t IslandFinder::root_of(std::uint32_t run) {
  while (groups_[run].parent != run) {
    groups_[run].parent = groups_[groups_[run].parent].parent;
    run = groups_[run].parent;
  }
  return run;
}

void IslandFinder::join(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = root_of(a), root_b = root_of(b);
  const std::uint32_t first = std::min(root_a, root_b);
  if (root_a == root_b) return;
  const Group& other = groups_[std::max(root_a, root_b)];
  groups_[first].bright += other.bright;
  groups_[first].contact += other.contact;
  groups_[std::max(root_a, root_b)].parent = first;
}

void IslandFinder::join_rows(const MaskRuns& layer, std::int32_t row) {
  const std::uint32_t above = layer.first_in_row(row - 1), here = layer.first_in_row(row);
  // One column's reach: pixels that touch by a corner.
  for_each_meeting(layer.in_row(row - 1), layer.in_row(row), 1, [&](std::size_t i, std::size_t j) {
    join(above + static_cast<std::uint32_t>(i), here + static_cast<std::uint32_t>(j));
  });
}

// Adds the pixels that the layer's runs share with the bright ones.
void IslandFinder::count_row(const MaskRuns& layer, const MaskRuns& bright, std::int32_t row,
                             std::int64_t Group::*count) {
  const std::uint32_t here = layer.first_in_row(row);
  const std::span<const PixelRun> runs = layer.in_row(row), others = bright.in_row(row);
  for_each_meeting(runs, others, 0, [&](std::size_t i, std::size_t j) {
    groups_[root_of(here + static_cast<std::uint32_t>(i))].*count +=
        std::min(runs[i].end, others[j].end) - std::max(runs[i].first, others[j].first);
  });
}

void IslandFinder::collect(const MaskRuns& layer, std::int64_t contact_pixels) {
  islands_.clear();
  island_of_.resize(groups_.size());
  for (std::uint32_t i = 0; i < groups_.size(); ++i) {
    const std::uint32_t root = root_of(i);
    const Group& group = groups_[root];
    if (group.contact >= std::min(contact_pixels, std::max<std::int64_t>(1, (group.bright + 1) / 2)))
      continue;
    const PixelRun& run = layer.runs()[i];
    if (root == i) {
      island_of_[i] = static_cast<std::uint32_t>(islands_.size());
      islands_.push_back({{0, 0}, run.first, run.row, run.end, run.row + 1, 0, 0});
    }
    MaskIsland& island = islands_[island_of_[root]];
    island.left = std::min(island.left, run.first);
    island.right = std::max(island.right, run.end);
    island.bottom = run.row + 1;
    const std::int64_t pixels = run.end - run.first;
    island.pixels += pixels;
    island.grey += run.grey;
    // Sums for now; of halves of whole numbers, hence exact.
    island.center.x += static_cast<double>(pixels * (run.first + run.end)) / 2;
    island.center.y += static_cast<double>(pixels * (2 * run.row + 1)) / 2;
  }
  for (MaskIsland& island : islands_) {
    island.center.x /= static_cast<double>(island.pixels);
    island.center.y /= static_cast<double>(island.pixels);
  }
}

}  // namespace contourd
