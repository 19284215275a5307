// Islands: connected groups of lit pixels with no lit pixel of the layer beneath under them. Nothing holds
// them while they cure; they sink, or stick to the vat's film. Keeps its memory between calls: allocates only
// while masks grow. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask_runs.hpp"
#include "core/pixel_map.hpp"

namespace contourd {

// In pixels of the mask; its pixels touch by sides or corners.
struct MaskIsland {
  PixelPoint center;                      // mean of its pixels' centres
  std::int32_t left, top, right, bottom;  // [left, right) by [top, bottom)
  std::int64_t pixels;
  std::uint64_t grey;  // sum of its grey values: 255 times its exposed area
};

class IslandFinder {
 public:
  // The islands of `layer` over `beneath`, in the order of their topmost runs. Valid until the next call.
  // REQUIRES: runs of masks of the same size.
  [[nodiscard]] std::span<const MaskIsland> find(const MaskRuns& layer, const MaskRuns& beneath);

 private:
  struct Group {
    std::uint32_t parent;  // a group's root is its own parent, and the first of its runs
    bool held;
  };

  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);
  void join_rows(const MaskRuns& layer, std::int32_t row);
  void hold_row(const MaskRuns& layer, const MaskRuns& beneath, std::int32_t row);
  void collect(const MaskRuns& layer);

  std::vector<Group> groups_;             // by run
  std::vector<std::uint32_t> island_of_;  // by root: its place in islands_
  std::vector<MaskIsland> islands_;
};

}  // namespace contourd
