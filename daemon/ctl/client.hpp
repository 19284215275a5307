// What contourctl asks of a daemon. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <string>

namespace contourd::ctl {

struct ClientOptions {
  std::filesystem::path socket;
  bool json = false;
};
// Sends one request (`method` as on the socket) and prints its answer for a person, or as it came.
int request(const ClientOptions& options, const std::string& method);

}  // namespace contourd::ctl
