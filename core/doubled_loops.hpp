// Leaves out loops that are in a section twice, because their facets are in the file twice. Painted twice,
// they would make the pixels on their edges too bright, and fill a hole.
//
// Only what closes is left out, so that the rest keeps its balance: a wall that two solids share is there
// twice, too, but each of them needs it. What is doubled without closing is ContourLinker's to drop, where it
// is one too many at both of its ends.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/segment.hpp"

namespace contourd {

// Keeps its working memory between calls: allocates only while sections grow. Not thread-safe.
class DoubledLoops {
 public:
  // What is left keeps its order. REQUIRES: no coordinate is -0, no segment without length.
  void drop_from(std::vector<Segment>& segments);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  // Where spare segments start: spare_[next] to spare_[end - 1] have not been walked yet.
  struct Start {
    Point point;
    std::uint32_t next, end;
    bool on_way;
  };

  void find_spare(std::span<const Segment> segments);
  void make_starts(std::span<const Segment> segments);
  [[nodiscard]] std::uint32_t start_at(const Point& point) const;
  void walk_from(std::uint32_t start, std::span<const Segment> segments);
  void drop_way_back_to(std::uint32_t start);

  struct Step {
    std::uint32_t start, segment;
  };

  std::vector<std::uint32_t> slots_;   // open addressing, by both ends: the first such segment
  std::vector<std::uint32_t> spare_;   // segments that are there once more before them, by where they start
  std::vector<Start> starts_;          // by point
  std::vector<Step> way_;              // head to tail
  std::vector<std::uint8_t> dropped_;  // by segment, 0 or 1
};

}  // namespace contourd
