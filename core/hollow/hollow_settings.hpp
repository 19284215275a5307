// Settings for hollowing a model. Values; thread-safe as any value is.
#pragma once

#include <optional>

#include "core/geometry/units.hpp"

namespace contourd {

// Struts along the four body diagonals of cubes: a lattice of open cells that carries a cavity's roof. The
// struts are 35 degrees above the level, and every strut begins on a wall, so that they need no supports.
struct InfillLattice {
  Millimeters cell{8.0};   // side of a cube
  Millimeters strut{1.0};  // diameter of a strut
  bool operator==(const InfillLattice&) const = default;
};

struct HollowSettings {
  Millimeters wall{2.0};  // least thickness of the walls, in all directions
  std::optional<InfillLattice> infill{};
  // Diameter of the holes that a cavity gets where it begins, unless it has a hole; 0: none.
  Millimeters hole{2.5};
  bool operator==(const HollowSettings&) const = default;
};

}  // namespace contourd
