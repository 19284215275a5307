// The caller of a method of the control interface. A value.
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace contourd {

struct ControlCaller {
  std::uint64_t connection = 0;  // tells connections apart, also those that are no more; from 1
  uid_t user = 0;
};

}  // namespace contourd
