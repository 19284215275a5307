// The points where a section's segments meet: which segments leave a point, and which points are unbalanced,
// that is, more segments leave than arrive, or fewer. Open chains begin and end at unbalanced points.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// A segment, directed so that the model's inside is on the left (seen from above).
struct Segment {
  Point from, to;
  bool operator==(const Segment&) const = default;
};

// Keeps its working memory between calls: allocates only while sections grow. Not thread-safe.
class SegmentEnds {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  // A point that more segments leave than reach, or fewer.
  struct UnbalancedPoint {
    std::uint64_t hash;
    Point point;
    // The lowest of the segment ends there: twice the segment's number, plus 1 if the segment arrives.
    std::uint32_t first_end;
    std::int32_t leaving_minus_arriving;
  };

  // Replaces the section. `segments` must stay unchanged until the next reset().
  void reset(std::span<const Segment> segments);

  // Return the segments that leave a point, one after the other in falling order of their numbers; kNone
  // after the last.
  [[nodiscard]] std::uint32_t first_leaving(const Point& point) const;
  [[nodiscard]] std::uint32_t next_leaving(std::uint32_t segment) const;

  // Returns the unbalanced points that more segments leave than reach, in the segments' order. The caller may
  // decrement leaving_minus_arriving.
  [[nodiscard]] std::span<UnbalancedPoint* const> starts() const { return starts_; }
  // Returns the unbalanced point here, or null if as many segments leave as arrive.
  [[nodiscard]] UnbalancedPoint* unbalanced_at(const Point& point);

 private:
  // An end of a segment, to be counted.
  struct End {
    std::uint64_t hash;  // hash of the point
    Point point;
    std::uint32_t number;  // as UnbalancedPoint::first_end
  };

  void find_unbalanced_points();
  [[nodiscard]] std::uint32_t first_of(std::uint32_t candidate, const Point& point) const;

  std::span<const Segment> segments_;
  // Linked lists of segments, by the hash of the point that they leave: the number of the last segment, and
  // by segment the number of the previous one.
  std::vector<std::uint32_t> last_, previous_;
  // Sums of the hashes of points that segments leave, minus those of points that they reach, by bucket: if a
  // bucket's sum is 0, its points are balanced.
  std::array<std::uint64_t, 1024> imbalance_{};
  std::vector<std::uint16_t> from_bucket_, to_bucket_;  // by segment
  std::vector<End> ends_;
  std::vector<UnbalancedPoint> unbalanced_;  // by hash
  std::vector<UnbalancedPoint*> starts_;
};

}  // namespace contourd
