// The caller of a method of the control interface. A value.
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace contourd {

struct ControlCaller {
  std::uint64_t connection = 0;  // unique among all connections so far, also closed ones; from 1
  uid_t user = 0;
};

}  // namespace contourd
