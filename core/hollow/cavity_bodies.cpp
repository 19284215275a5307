#include "core/hollow/cavity_bodies.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {

std::uint32_t CavityBodies::root_of(std::uint32_t run) {
  while (joined_[run] != run)
    run = joined_[run] = joined_[joined_[run]];
  return run;
}

void CavityBodies::join(std::uint32_t a, std::uint32_t b) {
  const auto [first, second] = std::minmax({root_of(a), root_of(b)});
  if (first == second) return;
  // Two parts that grew in earlier slices meet: the higher one was a basin of its own.
  if (cells_[first] >= least_cells_ && cells_[second] >= least_cells_)
    basins_.push_back({0, second, 0, static_cast<std::int32_t>(starts_.size()) - 1});
  joined_[second] = first;
  cells_[first] += cells_[second];
}

template <typename Meet>
void CavityBodies::for_meetings(std::size_t first, std::size_t end, std::size_t other_first,
                                std::size_t other_end, std::int32_t rows_apart, Meet&& meet) const {
  std::size_t i = first, j = other_first;
  while (i < end && j < other_end) {
    const CavityRun &a = runs_[i], &b = runs_[j];
    const std::int32_t row = a.row - rows_apart;
    if (row == b.row && a.first < b.end && b.first < a.end)
      meet(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    const bool a_ends_first = row != b.row ? row < b.row : a.end < b.end;
    ++(a_ends_first ? i : j);
  }
}

void CavityBodies::add_slice(std::span<const CavityRun> runs) {
  const std::size_t before = starts_.size() > 1 ? starts_[starts_.size() - 2] : 0, first = runs_.size();
  runs_.insert(runs_.end(), runs.begin(), runs.end());
  for (std::size_t i = first; i < runs_.size(); ++i)
    joined_.push_back(static_cast<std::uint32_t>(i));
  cells_.resize(runs_.size());
  const auto join_both = [this](std::uint32_t a, std::uint32_t b) { join(a, b); };
  for_meetings(first, runs_.size(), before, first, 0, join_both);
  for_meetings(first, runs_.size(), first, runs_.size(), 1, join_both);
  for (std::size_t i = first; i < runs_.size(); ++i)
    cells_[root_of(static_cast<std::uint32_t>(i))] +=
        static_cast<std::uint64_t>(runs_[i].end - runs_[i].first);
  starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
}

void CavityBodies::finish() {
  const auto slices = static_cast<std::int32_t>(starts_.size()) - 1;
  for (std::uint32_t i = 0; i < runs_.size(); ++i)
    if (joined_[i] == i && cells_[i] >= least_cells_) basins_.push_back({0, i, 0, slices});
  std::ranges::sort(basins_, {}, &CavityBasin::first_run);
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> bodies, starts{0};
  std::vector<std::uint32_t> numbers(runs_.size(), kNone);  // by root: the body
  std::vector<CavityRun> kept;
  auto basin = basins_.begin();
  for (std::int32_t slice = 0; slice < slices; ++slice) {
    const auto k = static_cast<std::size_t>(slice);
    for (std::uint32_t i = starts_[k]; i < starts_[k + 1]; ++i) {
      const std::uint32_t root = root_of(i);
      if (cells_[root] < least_cells_) continue;
      if (root == i) numbers[i] = static_cast<std::uint32_t>(bodies_++);
      if (basin != basins_.end() && basin->first_run == i) {
        *basin = {numbers[root], static_cast<std::uint32_t>(kept.size()), slice, basin->end};
        ++basin;
      }
      kept.push_back(runs_[i]);
      bodies.push_back(numbers[root]);
    }
    starts.push_back(static_cast<std::uint32_t>(kept.size()));
  }
  runs_ = std::move(kept);
  joined_ = std::move(bodies);
  starts_ = std::move(starts);
  cells_ = {};
}

std::vector<CavityRun> CavityBodies::in_basin(const CavityBasin& basin, std::int32_t slice) const {
  expects(basin.low <= slice && slice < basin.end, "the slice is one of the basin's");
  const std::size_t first = starts_[static_cast<std::size_t>(basin.low)];
  const std::size_t last = starts_[static_cast<std::size_t>(slice)];
  const std::size_t end = starts_[static_cast<std::size_t>(slice) + 1];
  std::vector<std::vector<std::uint32_t>> meetings(end - first);
  const auto note = [&](std::uint32_t a, std::uint32_t b) {
    meetings[a - first].push_back(b);
    meetings[b - first].push_back(a);
  };
  for (std::int32_t each = basin.low; each <= slice; ++each) {
    const std::size_t begin = starts_[static_cast<std::size_t>(each)];
    const std::size_t stop = starts_[static_cast<std::size_t>(each) + 1];
    for_meetings(begin, stop, begin, stop, 1, note);
    if (each > basin.low)
      for_meetings(begin, stop, starts_[static_cast<std::size_t>(each) - 1], begin, 0, note);
  }
  std::vector<char> reached(meetings.size());
  std::vector<std::uint32_t> front{basin.first_run};
  reached[basin.first_run - first] = 1;
  std::vector<CavityRun> found;
  while (!front.empty()) {
    const std::uint32_t run = front.back();
    front.pop_back();
    if (run >= last) found.push_back(runs_[run]);
    for (const std::uint32_t next : meetings[run - first])
      if (!std::exchange(reached[next - first], 1)) front.push_back(next);
  }
  return found;
}

}  // namespace contourd
