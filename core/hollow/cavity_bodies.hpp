// The connected bodies of a model's cavities, and the basins that they grow from: takes the slices from the
// lowest one up, as runs of cells, and joins runs that share a side of a cell. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hollow/cavity.hpp"

namespace contourd {

// A part of a body that begins by itself and is joined to a lower one, if at all, higher up.
struct CavityBasin {
  std::uint32_t body = 0;
  std::uint32_t first_run = 0;    // index of its first run
  std::int32_t low = 0, end = 0;  // slices [low, end): its lowest one, and the one that joins it
};

class CavityBodies {
 public:
  // Bodies and basins count if they have at least `least_cells` cells, a basin before it is joined.
  explicit CavityBodies(std::uint64_t least_cells) : least_cells_(least_cells) {}

  // Adds the next slice. `runs` are sorted by row, then by column.
  void add_slice(std::span<const CavityRun> runs);
  // Numbers the bodies that count, from 0 by their lowest runs, and removes the runs of all others.
  void finish();

  // All of these are valid after finish(), the runs and slices before it, too.
  [[nodiscard]] std::size_t bodies() const { return bodies_; }
  // Returns the basins of all bodies, from the lowest one; each body has at least one.
  [[nodiscard]] std::span<const CavityBasin> basins() const { return basins_; }
  [[nodiscard]] std::span<const CavityRun> runs() const { return runs_; }
  // Returns the index in runs() of each slice's first run, and their number at the end.
  [[nodiscard]] std::span<const std::uint32_t> starts() const { return starts_; }
  // Returns the body of a run, by its index in runs().
  [[nodiscard]] std::uint32_t body_of(std::size_t run) const { return joined_[run]; }
  // Returns the runs of a slice.
  [[nodiscard]] std::span<const CavityRun> in_slice(std::int32_t slice) const {
    const auto k = static_cast<std::size_t>(slice);
    return runs().subspan(starts_[k], starts_[k + 1] - starts_[k]);
  }
  // Returns the runs of a slice that are joined to the basin's first run by slices no higher. REQUIRES: the
  // slice is one of the basin's.
  [[nodiscard]] std::vector<CavityRun> in_basin(const CavityBasin& basin, std::int32_t slice) const;

 private:
  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);
  // Calls meet(a, b) for the runs a of [first, end) and b of [other_first, other_end) that share a column, b
  // `rows_apart` rows before a.
  template <typename Meet>
  void for_meetings(std::size_t first, std::size_t end, std::size_t other_first, std::size_t other_end,
                    std::int32_t rows_apart, Meet&& meet) const;

  std::uint64_t least_cells_;
  std::vector<CavityRun> runs_;
  std::vector<std::uint32_t> joined_;  // by run: an earlier run of the same body, or itself; then the body
  std::vector<std::uint64_t> cells_;   // by run that no earlier one is joined to: cells of earlier slices
  std::vector<std::uint32_t> starts_{0};
  std::size_t bodies_ = 0;
  std::vector<CavityBasin> basins_;
};

}  // namespace contourd
