// The message of the exception that a call throws.
#pragma once

#include <string>

namespace contourd::testing {

// Returns the message of the `Error` that the call throws; empty if the call throws none.
template <typename Error, typename Call>
[[nodiscard]] std::string message_of(const Call& call) {
  try {
    (void)call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace contourd::testing
