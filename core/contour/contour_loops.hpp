// Joins a section's segments head to tail into contour loops: the thesis's algorithm 2, in time linear in the
// number of segments (the thesis searches the rest of the list for each segment).
//
// The thesis's Find, Compare, isInvert and Swap work on pixel coordinates; this code compares exact points:
// where two facets share a side, their segments end in the very same bits (see intersect_side). Chains that
// stay open come from cracks, missing or turned facets; OpenChainJoiner closes them, and they are reported.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/layer_cracks.hpp"
#include "core/contour/open_chain_joiner.hpp"
#include "core/contour/segment_ends.hpp"
#include "core/contour/slicer.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// A closed polygon: a range of Contours::points; its last point is joined to its first.
struct ContourLoop {
  std::uint32_t first_point = 0;
  std::uint32_t point_count = 0;
};

struct Contours {
  std::vector<Point> points;
  // Outer loops run counter-clockwise, holes clockwise (seen from above), when the facets are wound as STL
  // demands.
  std::vector<ContourLoop> loops;
  LayerCracks cracks;                // gaps that were bridged to close the loops
  std::uint32_t repaired_loops = 0;  // loops with a closed open chain in them

  [[nodiscard]] std::span<const Point> points_of(const ContourLoop& loop) const {
    return std::span(points).subspan(loop.first_point, loop.point_count);
  }
  // Returns the number of loops that the file's facets close, by themselves or with gaps within the tolerance
  // (the thesis's LC).
  [[nodiscard]] std::uint32_t closed_loops() const {
    const auto all = static_cast<std::uint32_t>(loops.size());
    return all > repaired_loops ? all - repaired_loops : 0;
  }
};

// Returns the length of all loops' sides, in millimetres.
[[nodiscard]] double perimeter_mm(const Contours& contours);

// Keeps its working memory between calls: allocates only while sections grow. Not thread-safe.
class ContourLinker {
 public:
  // Joins `segments` into `contours`, replacing their contents. Ends up to `tolerance` apart count as
  // meeting. Once the budget is overrun, gaps are closed as they come.
  void link(std::span<const Segment> segments, Millimeters tolerance, Contours& contours, MaskBudget& budget);
  // Links without a limit on time.
  void link(std::span<const Segment> segments, Millimeters tolerance, Contours& contours);

  // Balances the segments of an unbalanced section, which is all that a mask needs: moves its open chains out
  // of `segments` and, closed as link() closes them, into `contours`, replacing their contents. The segments
  // left in `segments` form closed loops, in no order.
  void close_open_chains(std::vector<Segment>& segments, Millimeters tolerance, Contours& contours,
                         MaskBudget& budget);

 private:
  static constexpr std::uint32_t kNone = SegmentEnds::kNone;

  using UnbalancedPoint = SegmentEnds::UnbalancedPoint;

  // A run of segments that starts and ends in different points.
  struct Chain {
    std::uint32_t first_point, point_count;
  };

  static void clear(Contours& contours);
  [[nodiscard]] bool link_simple(std::span<const Segment> segments, Contours& contours);
  [[nodiscard]] std::uint32_t& slot_of(const Point& point, std::span<const Segment> segments);
  void find_ends(std::span<const Segment> segments);
  void walk_chains(std::span<const Segment> segments, Contours& contours);
  void drop_duplicates(std::span<const Segment> segments);
  [[nodiscard]] bool is_doubled(std::uint32_t segment, std::span<const Segment> segments);
  bool drop_run(std::uint32_t first, std::span<const Segment> segments);
  void walk_chains_from(UnbalancedPoint& start, std::span<const Segment> segments, Contours& contours);
  [[nodiscard]] std::uint32_t leftmost_leaving(std::uint32_t arrived_by, std::span<const Segment> segments);
  // Walks from an unused segment until it returns to the start point or no segment leaves; true if it
  // returned.
  bool walk(std::uint32_t segment, std::span<const Segment> segments, std::vector<Point>& points);
  void walk_loops(std::span<const Segment> segments, Contours& contours);
  void join_chains(Millimeters tolerance, Contours& contours, MaskBudget& budget);

  // For sections where every point joins two segments: a hash table of the segment that leaves a point, and
  // by segment the next segment.
  std::vector<std::uint32_t> slots_, next_;
  SegmentEnds ends_;
  std::vector<std::uint8_t> used_;  // by segment, 0 or 1
  std::vector<std::uint32_t> run_;  // a run of doubled segments
  std::size_t looks_left_ = 0;      // looks left for finding doubled segments
  std::vector<Point> chain_points_;
  std::vector<Chain> chains_;
  OpenChainJoiner joiner_;
};

}  // namespace contourd
