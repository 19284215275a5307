// A device that is not there, is somebody else's or does not do what it must: one sentence that says what,
// where, why, and where it helps what there is instead.
#pragma once

#include <stdexcept>

namespace contourd {

class HardwareError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
