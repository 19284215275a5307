// Lengths in millimetres, for tests.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd::testing {

inline Nanometers mm(double length) {
  return to_nanometers(Millimeters{length}).value();
}

}  // namespace contourd::testing
