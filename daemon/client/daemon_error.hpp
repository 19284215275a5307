// The exception of a client that cannot reach contourd.
#pragma once

#include <stdexcept>

namespace contourd {

// Thrown if contourd cannot be reached or the connection to it breaks. what() is a sentence for the user.
class DaemonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
