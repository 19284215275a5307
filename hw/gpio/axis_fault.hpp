// A fault that ends a motion of the axis or prevents one. A value type.
#pragma once

#include <string>

#include "hw/z_axis.hpp"

namespace contourd {

struct AxisFault {
  HomingResult homing = HomingResult::Fault;  // the result of a homing that it ends
  std::string what;                           // one sentence, with the line
  bool needs_user = false;                    // the emergency stop: nothing moves until the operator decides
};

}  // namespace contourd
