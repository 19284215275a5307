// The commands that turn the web page on: the password, and the addresses on which the service listens. Run
// by contourctl web. Main thread only; they block until the user has answered.
#pragma once

#include <string>
#include <vector>

namespace contourd::web {

inline constexpr const char* kDefaultSecrets = "/etc/contourd/web-password";
inline constexpr const char* kDefaultSocketUnit = "/etc/systemd/system/contourd-web.socket.d";
inline constexpr const char* kDefaultAddress = "127.0.0.1:8080";

// Asks for a new password, on a terminal twice and without echo, otherwise by a line of standard input, and
// stores its hash and a new key for slicers. On a terminal, also asks whether to listen on this computer's
// addresses in the local network. Returns the exit code.
int set_password(const std::string& secrets_file, const std::string& socket_unit);

// Makes the service listen on these addresses from its next start on; without any, prints the addresses.
// Throws std::runtime_error for an address that is none.
int set_addresses(const std::vector<std::string>& addresses, const std::string& socket_unit);

}  // namespace contourd::web
