// The exception for a job that cannot be printed.
#pragma once

#include <stdexcept>

namespace contourd {

// Thrown if a job cannot be printed. what() tells the user what is wrong, where, and why.
class JobRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
