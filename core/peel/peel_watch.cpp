#include "core/peel/peel_watch.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

bool PeelWatch::change(bool active, Nanometers height) {
  // The force before the lift was that of pressed resin or of a tense film: its end says nothing.
  if (std::exchange(stays_active_, false)) return false;
  if (active) {
    peel_.felt = true;
    return false;
  }
  peel_.distance = height - from_;
  return true;
}

PeelFinding PeelWatch::judge(double area_mm2) {
  const bool unknown = began_active_ && !peel_.felt;
  if (area_mm2 < least_area_mm2_ || unknown) return PeelFinding::None;
  if (peel_.felt) {
    ++felt_;
    smallest_felt_mm2_ = std::min(smallest_felt_mm2_.value_or(area_mm2), area_mm2);
    return PeelFinding::None;
  }
  if (!smallest_felt_mm2_) return ++silent_ == kSilentFromStart ? PeelFinding::NeverFelt : PeelFinding::None;
  if (felt_ < kFeltBefore || area_mm2 < *smallest_felt_mm2_) return PeelFinding::None;
  felt_ = 0;
  return PeelFinding::CameOff;
}

}  // namespace contourd
