// Islands: connected groups of pixels that the layer beneath does not carry. Nothing holds them while they
// cure, so they sink or stick to the vat's film.
//
// Only pixels bright enough to cure hard count: a faint pixel neither carries nor connects, nor is it part of
// a group. A mere corner does not carry either, but a small group needs only a third of itself above bright
// pixels: a thin pin stands on its own. A speck (an island of at most speck_grey) is reported only if a group
// of the next layer would not be carried without it: one layer's light is too little to cure a speck.
// Keeps its memory between calls: allocates only while masks grow. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// An island in pixels of the mask; its pixels touch by sides or corners.
struct MaskIsland {
  PixelPoint center;                      // mean of the pixels' centres
  std::int32_t left, top, right, bottom;  // [left, right) by [top, bottom)
  std::int64_t pixels;
  std::uint64_t grey;  // sum of the grey values: 255 times the exposed area
};

class IslandFinder {
 public:
  struct Limits {
    std::int64_t contact_pixels;  // pixels under a group that suffice to carry it
    std::uint64_t speck_grey;     // most grey of an island that counts as a speck
  };
  // Islands in the order of their topmost runs.
  struct Islands {
    std::span<const MaskIsland> here;     // in the layer; its specks are decided on the next call
    std::span<const MaskIsland> beneath;  // specks of the layer before that turned out to be islands
  };

  // Returns the islands of `layer` over `beneath`, each given by its bright pixels. Valid until the next
  // call. REQUIRES: runs of masks of the same size; `beneath` is the last call's layer.
  [[nodiscard]] Islands find(const MaskRuns& layer, const MaskRuns& beneath, const Limits& limits);

 private:
  struct Group {
    std::uint32_t parent;  // a group's root is its own parent, and the first of its runs
    std::int64_t pixels;   // pixels of the group
    std::int64_t contact;  // bright pixels beneath the group
    std::int64_t specks;   // pixels of `contact` that belong to specks
  };
  // The specks of the last layer; runs from the top row down.
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
  std::vector<std::uint32_t> island_of_;  // by root: index in islands_
  std::vector<MaskIsland> islands_, outlasting_;
  Specks specks_;
  std::vector<std::uint32_t> speck_of_;  // by island: index in specks_
  std::vector<bool> outlasts_;           // by speck
};

}  // namespace contourd
