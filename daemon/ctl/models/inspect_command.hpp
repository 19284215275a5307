// contourctl inspect: shows the contents and defects of a model's file. Prints its result and returns the
// exit code. Problems with the data are thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>

namespace contourd::ctl {

struct InspectOptions {
  std::filesystem::path model;
  bool json = false;
};
int inspect(const InspectOptions& options);

}  // namespace contourd::ctl
