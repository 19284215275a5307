// contourctl inspect. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>

namespace contourd::ctl {

struct InspectOptions {
  std::filesystem::path model;
  bool json = false;
};
int inspect(const InspectOptions& options);

}  // namespace contourd::ctl
