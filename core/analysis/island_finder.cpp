#include "core/analysis/island_finder.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {

namespace {

constexpr std::uint32_t kNone = 0xFFFF'FFFF;

// Calls visit(row, the row's runs, index of its first run) for each row that has runs.
template <typename Visit>
void for_each_row(std::span<const PixelRun> runs, Visit&& visit) {
  for (std::size_t first = 0; first < runs.size();) {
    std::size_t end = first;
    while (end < runs.size() && runs[end].row == runs[first].row)
      ++end;
    visit(runs[first].row, runs.subspan(first, end - first), first);
    first = end;
  }
}

std::int32_t shared_pixels(const PixelRun& a, const PixelRun& b) {
  return std::min(a.end, b.end) - std::max(a.first, b.first);
}

}  // namespace

IslandFinder::Islands IslandFinder::find(const MaskRuns& layer, const MaskRuns& beneath,
                                         const Limits& limits) {
  expects(beneath.rows() == layer.rows(), "all masks have one size");
  limits_ = limits;
  groups_.clear();
  for (const PixelRun& run : layer.runs())
    groups_.push_back({static_cast<std::uint32_t>(groups_.size()), run.end - run.first, 0, 0});
  for (std::int32_t row = 0; row < layer.rows(); ++row) {
    if (layer.in_row(row).empty()) continue;
    if (row > 0) join_rows(layer, row);
    count_contact(layer, beneath, row);
  }
  settle_specks(layer);
  collect(layer);
  set_specks_aside(layer);
  return {islands_, outlasting_};
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
  groups_[first].pixels += other.pixels;
  groups_[first].contact += other.contact;
  groups_[first].specks += other.specks;
  groups_[std::max(root_a, root_b)].parent = first;
}

void IslandFinder::join_rows(const MaskRuns& layer, std::int32_t row) {
  const std::uint32_t above = layer.first_in_row(row - 1), here = layer.first_in_row(row);
  // A reach of one column includes pixels that touch by a corner.
  for_each_meeting(layer.in_row(row - 1), layer.in_row(row), 1, [&](std::size_t i, std::size_t j) {
    join(above + static_cast<std::uint32_t>(i), here + static_cast<std::uint32_t>(j));
  });
}

// Adds the pixels that the layer's runs share with the runs beneath.
void IslandFinder::count_contact(const MaskRuns& layer, const MaskRuns& beneath, std::int32_t row) {
  const std::uint32_t here = layer.first_in_row(row);
  const std::span<const PixelRun> runs = layer.in_row(row), others = beneath.in_row(row);
  for_each_meeting(runs, others, 0, [&](std::size_t i, std::size_t j) {
    groups_[root_of(here + static_cast<std::uint32_t>(i))].contact += shared_pixels(runs[i], others[j]);
  });
}

bool IslandFinder::is_carried(const Group& group, std::int64_t contact) const {
  return contact >= std::min(limits_.contact_pixels, std::max<std::int64_t>(1, (group.pixels + 2) / 3));
}

// Decides which specks of the layer before are islands: a speck is one if it carries a group that would not
// be carried without specks. A group that is not carried even with them is an island of its own.
void IslandFinder::settle_specks(const MaskRuns& layer) {
  outlasting_.clear();
  outlasts_.assign(specks_.islands.size(), false);
  const auto group_of = [&](std::int32_t row, std::size_t run) -> Group& {
    return groups_[root_of(layer.first_in_row(row) + static_cast<std::uint32_t>(run))];
  };
  for_each_row(specks_.runs, [&](std::int32_t row, std::span<const PixelRun> specks, std::size_t) {
    const std::span<const PixelRun> runs = layer.in_row(row);
    for_each_meeting(runs, specks, 0, [&](std::size_t i, std::size_t j) {
      group_of(row, i).specks += shared_pixels(runs[i], specks[j]);
    });
  });
  for_each_row(specks_.runs, [&](std::int32_t row, std::span<const PixelRun> specks, std::size_t first) {
    for_each_meeting(layer.in_row(row), specks, 0, [&](std::size_t i, std::size_t j) {
      const Group& group = group_of(row, i);
      if (is_carried(group, group.contact) && !is_carried(group, group.contact - group.specks))
        outlasts_[specks_.island_of[first + j]] = true;
    });
  });
  for (std::size_t i = 0; i < outlasts_.size(); ++i)
    if (outlasts_[i]) outlasting_.push_back(specks_.islands[i]);
}

void IslandFinder::collect(const MaskRuns& layer) {
  islands_.clear();
  island_of_.assign(groups_.size(), kNone);
  for (std::uint32_t i = 0; i < groups_.size(); ++i) {
    const std::uint32_t root = root_of(i);
    const Group& group = groups_[root];
    if (is_carried(group, group.contact)) continue;
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
    // Sums for now; exact, since they add halves of whole numbers.
    island.center.x += static_cast<double>(pixels * (run.first + run.end)) / 2;
    island.center.y += static_cast<double>(pixels * (2 * run.row + 1)) / 2;
  }
  for (MaskIsland& island : islands_) {
    island.center.x /= static_cast<double>(island.pixels);
    island.center.y /= static_cast<double>(island.pixels);
  }
}

// Moves specks from islands_ to specks_.
void IslandFinder::set_specks_aside(const MaskRuns& layer) {
  specks_.islands.clear();
  specks_.runs.clear();
  specks_.island_of.clear();
  const auto is_speck = [this](const MaskIsland& island) { return island.grey <= limits_.speck_grey; };
  if (std::ranges::none_of(islands_, is_speck)) return;
  // By island: its index among the specks.
  speck_of_.assign(islands_.size(), kNone);
  for (std::size_t i = 0; i < islands_.size(); ++i) {
    if (!is_speck(islands_[i])) continue;
    speck_of_[i] = static_cast<std::uint32_t>(specks_.islands.size());
    specks_.islands.push_back(islands_[i]);
  }
  for (std::uint32_t i = 0; i < groups_.size(); ++i) {
    const std::uint32_t island = island_of_[root_of(i)];
    if (island == kNone || speck_of_[island] == kNone) continue;
    specks_.runs.push_back(layer.runs()[i]);
    specks_.island_of.push_back(speck_of_[island]);
  }
  std::erase_if(islands_, is_speck);
}

}  // namespace contourd
