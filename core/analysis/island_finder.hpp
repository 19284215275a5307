// Islands: connected groups of pixels that the layer beneath does not carry. Nothing holds them while they
// cure; they sink, or stick to the vat's film.
//
// Only pixels that are bright enough to cure hard count: a faint one neither carries nor connects, nor is it
// a part. A mere corner does not carry either; but a group that is small itself needs no more under it than a
// third of itself: a thin pin stands on its own. What is a speck in its first layer, and is gone in the next
// or part of what something else carries there, is no island: it is less than a layer's light lets cure to
// anything, and held by then. Keeps its memory between calls: allocates only while masks grow. Not
// thread-safe.
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
  struct Limits {
    std::int64_t contact_pixels;  // under a group that carry it
    std::uint64_t speck_grey;     // that an island has at most that is a speck
  };
  // In the order of their topmost runs.
  struct Islands {
    std::span<const MaskIsland> here;     // in the layer; specks are told with the next one
    std::span<const MaskIsland> beneath;  // those specks of the layer before that are islands
  };

  // The islands of `layer` over `beneath`, each given by its bright pixels. Valid until the next call.
  // REQUIRES: runs of masks of the same size; `beneath` is the last call's layer.
  [[nodiscard]] Islands find(const MaskRuns& layer, const MaskRuns& beneath, const Limits& limits);

 private:
  struct Group {
    std::uint32_t parent;  // a group's root is its own parent, and the first of its runs
    std::int64_t pixels;   // of its own
    std::int64_t contact;  // pixels beneath it
    std::int64_t specks;   // of these, those of specks
  };
  // The last layer's specks, as runs from the top row down.
  struct Specks {
    std::vector<MaskIsland> islands;
    std::vector<PixelRun> runs;
    std::vector<std::uint32_t> island_of;  // by run
  };

  [[nodiscard]] std::uint32_t root_of(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);
  void join_rows(const MaskRuns& layer, std::int32_t row);
  void count_contact(const MaskRuns& layer, const MaskRuns& beneath, std::int32_t row);
  [[nodiscard]] bool is_carried(const Group& group, std::int64_t contact) const;
  void settle_specks(const MaskRuns& layer);
  void collect(const MaskRuns& layer);
  void set_specks_aside(const MaskRuns& layer);

  Limits limits_{};
  std::vector<Group> groups_;             // by run
  std::vector<std::uint32_t> island_of_;  // by root: its place in islands_
  std::vector<MaskIsland> islands_, outlasting_;
  Specks specks_;
  std::vector<std::uint32_t> speck_of_;  // by island: its place in specks_
  std::vector<bool> outlasts_;           // by speck
};

}  // namespace contourd
