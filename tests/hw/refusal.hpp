// The message of the exception that a call throws.
#pragma once

#include <string>

#include "hw/hardware_error.hpp"
#include "tests/message_of.hpp"

namespace contourd::testing {

// Returns the message of the `Error` that the call throws; empty if the call throws none.
template <typename Error = HardwareError, typename Call>
[[nodiscard]] std::string refusal_of(const Call& call) {
  return message_of<Error>(call);
}

}  // namespace contourd::testing
