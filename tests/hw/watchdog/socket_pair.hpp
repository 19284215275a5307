// Two connected sockets for tests.
#pragma once

#include <sys/socket.h>

#include <stdexcept>
#include <utility>

#include "hw/file_descriptor.hpp"

namespace contourd::testing {

inline std::pair<FileDescriptor, FileDescriptor> socket_pair(int type) {
  int ends[2];
  if (::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends) != 0) throw std::runtime_error("no socket pair");
  return {FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

}  // namespace contourd::testing
