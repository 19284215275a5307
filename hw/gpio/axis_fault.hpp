// What ends a motion of the axis, or keeps one from beginning. A value type.
#pragma once

#include <string>

#include "hw/z_axis.hpp"

namespace contourd {

struct AxisFault {
  HomingResult homing = HomingResult::Fault;  // what homing answers
  std::string what;                           // one sentence, with the line
  bool owner_decides = false;                 // the emergency stop: nothing moves by itself after that
};

}  // namespace contourd
