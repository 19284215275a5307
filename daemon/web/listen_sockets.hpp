// The sockets on which the web page listens. Thread-safe (no shared state).
#pragma once

#include <string>
#include <vector>

#include "hw/file_descriptor.hpp"

namespace contourd::web {

// Returns the listening sockets that the service manager has passed (sd_listen_fds(3)); none without a
// manager.
[[nodiscard]] std::vector<FileDescriptor> passed_sockets();

// Returns a socket that listens on ADDRESS:PORT, where ADDRESS is numeric, and an IPv6 one in brackets.
// Throws std::runtime_error with a sentence.
[[nodiscard]] FileDescriptor listen_on(const std::string& address);

// Throws std::runtime_error with a sentence if the text is no such ADDRESS:PORT.
void check_address(const std::string& address);

// Returns the addresses at which other computers of the local network can reach this one.
[[nodiscard]] std::vector<std::string> network_addresses();

// Returns the ADDRESS:PORT of each of these sockets.
[[nodiscard]] std::vector<std::string> addresses_of(const std::vector<FileDescriptor>& sockets);

// Returns the port of a socket; 0 if it has none.
[[nodiscard]] int port_of(const FileDescriptor& socket);

// Returns the names of this computer in lower case: the host name, and its first part.
[[nodiscard]] std::vector<std::string> own_names();

}  // namespace contourd::web
