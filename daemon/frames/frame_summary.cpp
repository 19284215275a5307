#include "daemon/frames/frame_summary.hpp"

#include <algorithm>

namespace contourd {
namespace {

// Takes over a way that is longer.
void take_longer(FrameSummary::Distance& longest, Nanometers way, Nanometers plate) {
  if (way > longest.way) longest = {way, plate};
}

}  // namespace

FrameSummary summary_of(std::span<const FrameRecord> frames) {
  FrameSummary summary{.masks = frames.size()};
  if (frames.empty()) return summary;
  summary.lowest = frames.front().first;
  summary.highest = frames.front().last;
  const Nanometers first_below = frames.front().first - frames.front().cut;
  summary.nearest = summary.farthest = {first_below, frames.front().first};
  for (const FrameRecord& frame : frames) {
    summary.rises += frame.begins ? 1 : 0;
    summary.refreshes += frame.refreshes;
    summary.missed += frame.missed;
    summary.lit += frame.lit;
    summary.lowest = std::min({summary.lowest, frame.first, frame.last});
    summary.highest = std::max({summary.highest, frame.first, frame.last});
    const Nanometers below = frame.first - frame.cut;
    if (below < summary.nearest.way) summary.nearest = {below, frame.first};
    take_longer(summary.farthest, below, frame.first);
    take_longer(summary.longest, frame.last - frame.first, frame.last);
  }
  return summary;
}

}  // namespace contourd
