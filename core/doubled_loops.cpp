#include "core/doubled_loops.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <tuple>

#include "core/point_hash.hpp"

namespace contourd {
namespace {

bool before(const Point& a, const Point& b) {
  return std::tie(a.x, a.y) < std::tie(b.x, b.y);
}

}  // namespace

void DoubledLoops::drop_from(std::vector<Segment>& segments) {
  find_spare(segments);
  if (spare_.empty()) return;
  make_starts(segments);
  dropped_.assign(segments.size(), 0);
  for (std::uint32_t start = 0; start < starts_.size(); ++start) {
    while (starts_[start].next < starts_[start].end)
      walk_from(start, segments);
  }
  std::size_t left = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (dropped_[i] == 0) segments[left++] = segments[i];
  }
  segments.resize(left);
}

void DoubledLoops::find_spare(std::span<const Segment> segments) {
  spare_.clear();
  slots_.assign(std::bit_ceil(segments.size() * 2 + 1), kNone);
  const std::size_t last = slots_.size() - 1;
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    std::size_t slot = mixed(hash_of_bits(segment.from), hash_of_bits(segment.to)) & last;
    while (slots_[slot] != kNone && !(segments[slots_[slot]] == segment))
      slot = (slot + 1) & last;
    if (slots_[slot] == kNone)
      slots_[slot] = i;
    else
      spare_.push_back(i);
  }
}

void DoubledLoops::make_starts(std::span<const Segment> segments) {
  std::sort(spare_.begin(), spare_.end(), [segments](std::uint32_t a, std::uint32_t b) {
    if (segments[a].from == segments[b].from) return a < b;
    return before(segments[a].from, segments[b].from);
  });
  starts_.clear();
  for (std::uint32_t i = 0; i < spare_.size(); ++i) {
    const Point& point = segments[spare_[i]].from;
    if (starts_.empty() || !(starts_.back().point == point)) starts_.push_back({point, i, i, false});
    ++starts_.back().end;
  }
}

// Which start lies in this point, or kNone.
std::uint32_t DoubledLoops::start_at(const Point& point) const {
  const auto at = std::lower_bound(starts_.begin(), starts_.end(), point,
                                   [](const Start& start, const Point& p) { return before(start.point, p); });
  return at != starts_.end() && at->point == point ? static_cast<std::uint32_t>(at - starts_.begin()) : kNone;
}

// Walks along spare segments. Where the way meets itself, that loop is dropped; where it leads nowhere, it
// goes back by a step, which cannot be part of a loop and stays.
void DoubledLoops::walk_from(std::uint32_t start, std::span<const Segment> segments) {
  std::uint32_t here = start;
  do {
    if (here != kNone && starts_[here].on_way) {
      drop_way_back_to(here);
    } else if (here != kNone && starts_[here].next < starts_[here].end) {
      const std::uint32_t segment = spare_[starts_[here].next++];
      starts_[here].on_way = true;
      way_.push_back({here, segment});
      here = start_at(segments[segment].to);
    } else {
      here = way_.back().start;
      starts_[here].on_way = false;
      way_.pop_back();
    }
  } while (!way_.empty());
}

void DoubledLoops::drop_way_back_to(std::uint32_t start) {
  while (starts_[start].on_way) {
    starts_[way_.back().start].on_way = false;
    dropped_[way_.back().segment] = 1;
    way_.pop_back();
  }
}

}  // namespace contourd
