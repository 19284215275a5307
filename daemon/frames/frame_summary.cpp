#include "daemon/frames/frame_summary.hpp"

#include <algorithm>

namespace contourd {
namespace {

void take_farthest(FrameSummary::Distance& farthest, Nanometers cut, Nanometers plate) {
  const Nanometers apart = std::max(cut, plate) - std::min(cut, plate);
  if (apart > farthest.apart) farthest = {apart, plate};
}

}  // namespace

FrameSummary summary_of(std::span<const FrameRecord> frames) {
  FrameSummary summary{.masks = frames.size()};
  if (frames.empty()) return summary;
  summary.lowest = frames.front().first;
  summary.highest = frames.front().last;
  for (const FrameRecord& frame : frames) {
    summary.rises += frame.begins ? 1 : 0;
    summary.refreshes += frame.refreshes;
    summary.missed += frame.missed;
    summary.lit += frame.lit;
    summary.lowest = std::min({summary.lowest, frame.first, frame.last});
    summary.highest = std::max({summary.highest, frame.first, frame.last});
    take_farthest(summary.farthest_first, frame.cut, frame.first);
    take_farthest(summary.farthest, frame.cut, frame.first);
    take_farthest(summary.farthest, frame.cut, frame.last);
  }
  return summary;
}

}  // namespace contourd
