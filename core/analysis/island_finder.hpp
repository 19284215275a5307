// Islands: connected groups of lit pixels that the layer beneath does not carry. Nothing holds them while
// they cure; they sink, or stick to the vat's film.
//
// What carries is bright enough to have cured hard, and large enough to hold: a faint pixel or a mere corner
// does not. A group that is small itself needs no more under it than half of what is bright in it: a thin pin
// stands on its own. Keeps its memory between calls: allocates only while masks grow. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

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
  // A layer's lit pixels, and those of them that are bright enough to carry.
  struct Layer {
    MaskRuns lit, bright;
  };

  // The islands of `layer` over `beneath`, in the order of their topmost runs; `contact_pixels` bright pixels
  // under a group carry it. Valid until the next call. REQUIRES: runs of masks of the same size.
  [[nodiscard]] std::span<const MaskIsland> find(const Layer& layer, const Layer& beneath,
                                                 std::int64_t contact_pixels);

 private:
  struct Group {
    std::uint32_t parent;  // a group's root is its own parent, and the first of its runs
    std::int64_t bright;   // pixels of its own
    std::int64_t contact;  // bright ones beneath it
  };

  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);
  void join_rows(const MaskRuns& layer, std::int32_t row);
  void count_row(const MaskRuns& layer, const MaskRuns& bright, std::int32_t row, std::int64_t Group::*count);
  void collect(const MaskRuns& layer, std::int64_t contact_pixels);

  std::vector<Group> groups_;             // by run
  std::vector<std::uint32_t> island_of_;  // by root: its place in islands_
  std::vector<MaskIsland> islands_;
};

}  // namespace contourd
