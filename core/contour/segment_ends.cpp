#include "core/contour/segment_ends.hpp"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "core/geometry/point_hash.hpp"

namespace contourd {

void SegmentEnds::reset(std::span<const Segment> segments) {
  segments_ = segments;
  last_.assign(std::bit_ceil(segments.size() + 1), kNone);
  previous_.resize(segments.size());
  imbalance_.fill(0);
  from_bucket_.resize(segments.size());
  to_bucket_.resize(segments.size());
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const std::uint64_t from = hash_of(segments[i].from);
    const std::uint64_t to = hash_of(segments[i].to);
    from_bucket_[i] = static_cast<std::uint16_t>(from % imbalance_.size());
    to_bucket_[i] = static_cast<std::uint16_t>(to % imbalance_.size());
    imbalance_[from_bucket_[i]] += from;
    imbalance_[to_bucket_[i]] -= to;
    previous_[i] = std::exchange(last_[from & (last_.size() - 1)], i);
  }
  find_unbalanced_points();
}

void SegmentEnds::find_unbalanced_points() {
  ends_.clear();
  for (std::uint32_t i = 0; i < segments_.size(); ++i) {
    const Segment& segment = segments_[i];
    if (imbalance_[from_bucket_[i]] != 0) ends_.push_back({hash_of(segment.from), segment.from, 2 * i});
    if (imbalance_[to_bucket_[i]] != 0) ends_.push_back({hash_of(segment.to), segment.to, 2 * i + 1});
  }
  const auto key = [](const auto& end) { return std::tie(end.hash, end.point.x, end.point.y); };
  std::sort(ends_.begin(), ends_.end(), [&key](const End& a, const End& b) {
    return key(a) != key(b) ? key(a) < key(b) : a.number < b.number;
  });
  unbalanced_.clear();
  for (auto end = ends_.begin(); end != ends_.end();) {
    UnbalancedPoint point{end->hash, end->point, end->number, 0};
    for (; end != ends_.end() && key(*end) == key(point); ++end)
      point.leaving_minus_arriving += end->number % 2 == 0 ? 1 : -1;
    if (point.leaving_minus_arriving != 0) unbalanced_.push_back(point);
  }
  starts_.clear();
  for (UnbalancedPoint& point : unbalanced_) {
    if (point.leaving_minus_arriving > 0) starts_.push_back(&point);
  }
  std::sort(starts_.begin(), starts_.end(),
            [](const UnbalancedPoint* a, const UnbalancedPoint* b) { return a->first_end < b->first_end; });
}

SegmentEnds::UnbalancedPoint* SegmentEnds::unbalanced_at(const Point& point) {
  const std::uint64_t hash = hash_of(point);
  const auto before = [](const UnbalancedPoint& unbalanced, std::uint64_t value) {
    return unbalanced.hash < value;
  };
  auto at = std::lower_bound(unbalanced_.begin(), unbalanced_.end(), hash, before);
  while (at != unbalanced_.end() && at->hash == hash && !(at->point == point))
    ++at;
  return at != unbalanced_.end() && at->hash == hash ? &*at : nullptr;
}

std::uint32_t SegmentEnds::first_leaving(const Point& point) const {
  return first_of(last_[hash_of(point) & (last_.size() - 1)], point);
}

std::uint32_t SegmentEnds::next_leaving(std::uint32_t segment) const {
  return first_of(previous_[segment], segments_[segment].from);
}

// Returns the first segment of a list, from this candidate on, that leaves this point.
std::uint32_t SegmentEnds::first_of(std::uint32_t candidate, const Point& point) const {
  while (candidate != kNone && !(segments_[candidate].from == point))
    candidate = previous_[candidate];
  return candidate;
}

}  // namespace contourd
