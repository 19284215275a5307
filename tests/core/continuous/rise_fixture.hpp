// Speeds as tables of continuous printing have them.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd::testing {

inline double mm_h(MillimetersPerSecond speed) {
  return speed.count() * 3600;
}

}  // namespace contourd::testing
