// What holds a print, as it branches: from the tips' joints down to the feet. Values; thread-safe as any
// value is.
#pragma once

#include <cstdint>
#include <vector>

#include "core/routing/support_tips.hpp"

namespace contourd {

// What a node stands on, if it is a foot.
enum class SupportFoot : std::uint8_t {
  None,
  OnPlate,
  OnModel,
  OfTip,  // a tip's own end, on the plate or on a model
};

// A joint of a tip, a bend, a place where branches meet, or a foot.
struct SupportNode {
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  PlatePoint place;
  std::uint32_t below = kNone;  // the node that the branch leads down to; none from a foot
  double load_mm2 = 0;          // of a layer's area, that comes down through here
  double radius_mm = 0;         // of the branch down to the next node
  SupportFoot foot = SupportFoot::None;
};

struct SupportTree {
  struct HeldTip {
    SupportTip tip;
    std::uint32_t contact = 0, node = 0;  // which it holds; its joint
  };

  std::vector<SupportNode> nodes;
  std::vector<HeldTip> tips;
};

}  // namespace contourd
