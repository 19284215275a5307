// The exception of a job that cannot be printed.
#pragma once

#include <stdexcept>

namespace contourd {

// The job cannot be printed. what() is for the owner: what, where, why.
class JobRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
