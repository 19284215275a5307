// The tree of a print's supports, from the tips' joints down to the feet. Values; thread-safe as any value
// is.
#pragma once

#include <cstdint>
#include <vector>

#include "core/routing/support_tips.hpp"

namespace contourd {

// The surface on which a node stands, if the node is a foot.
enum class SupportFoot : std::uint8_t {
  None,
  OnPlate,
  OnModel,
  OfTip,  // a tip's own end, on the plate or on a model
};

// A tip's joint, a bend, a junction of branches, or a foot.
struct SupportNode {
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  PlatePoint place;
  std::uint32_t below = kNone;  // the node at the lower end of the branch; kNone for a foot
  double load_mm2 = 0;          // area of a layer whose load passes through the node
  double radius_mm = 0;         // radius of the branch down to the next node
  SupportFoot foot = SupportFoot::None;
};

struct SupportTree {
  struct HeldTip {
    SupportTip tip;
    std::uint32_t contact = 0, node = 0;  // the contact that the tip holds; the node of its joint
  };

  std::vector<SupportNode> nodes;
  std::vector<HeldTip> tips;
};

}  // namespace contourd
