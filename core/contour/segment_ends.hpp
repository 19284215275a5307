// Where a section's segments meet: which of them leave a point, and which points are unbalanced, that is,
// more segments leave than arrive, or fewer. Open chains begin and end there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/segment.hpp"

namespace contourd {

// Keeps its working memory between calls: allocates only while sections grow. Not thread-safe.
class SegmentEnds {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  // A point that more segments leave than reach, or fewer.
  struct UnbalancedPoint {
    std::uint64_t hash;
    Point point;
    // The lowest of its ends: a segment's number, twice, and 1 more where the segment arrives.
    std::uint32_t first_end;
    std::int32_t leaving_minus_arriving;
  };

  // Takes up another section. `segments` must stay as they are until the next reset().
  void reset(std::span<const Segment> segments);

  // The segments that leave a point, one after the other in falling order of their numbers; kNone after the
  // last.
  [[nodiscard]] std::uint32_t first_leaving(const Point& point) const;
  [[nodiscard]] std::uint32_t next_leaving(std::uint32_t segment) const;

  // The unbalanced points that more segments leave than reach, in the segments' order. The caller may
  // decrement leaving_minus_arriving.
  [[nodiscard]] std::span<UnbalancedPoint* const> starts() const { return starts_; }
  // Null where as many segments leave as arrive.
  [[nodiscard]] UnbalancedPoint* unbalanced_at(const Point& point);

 private:
  // One of a segment's ends, to be counted.
  struct End {
    std::uint64_t hash;  // of the point
    Point point;
    std::uint32_t number;  // as UnbalancedPoint::first_end
  };

  void find_unbalanced_points();
  [[nodiscard]] std::uint32_t first_of(std::uint32_t candidate, const Point& point) const;

  std::span<const Segment> segments_;
  // Lists of segments, by the hash of the point that they leave: the last one's number, and by segment the
  // one before it.
  std::vector<std::uint32_t> last_, previous_;
  // Sums of the hashes of points that segments leave, less those that they reach: where a bucket's sum is 0,
  // its points are even.
  std::array<std::uint64_t, 1024> imbalance_{};
  std::vector<std::uint16_t> from_bucket_, to_bucket_;  // by segment
  std::vector<End> ends_;
  std::vector<UnbalancedPoint> unbalanced_;  // by hash
  std::vector<UnbalancedPoint*> starts_;
};

}  // namespace contourd
