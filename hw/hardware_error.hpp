// The error for a device that is missing, used by another program or not working: one sentence with the
// device, its place, the reason and, where it helps, the alternatives that exist.
#pragma once

#include <stdexcept>

namespace contourd {

class HardwareError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
