// The commands that turn the web page on: the password, and the addresses on which the service listens. Run
// by contourctl web. Main thread only; they block until the user has answered.
#pragma once

#include <string>
#include <vector>

#include "daemon/web/announcement.hpp"
#include "daemon/web/page/role.hpp"

namespace contourd::web {

inline constexpr const char* kDefaultSecrets = "/etc/contourd/web-password";
inline constexpr const char* kDefaultSocketUnit = "/etc/systemd/system/contourd-web.socket.d";
inline constexpr const char* kDefaultAddress = "127.0.0.1:8080";

// The files by which the page is set up.
struct WebFiles {
  std::string secrets = kDefaultSecrets;
  std::string socket_unit = kDefaultSocketUnit;     // folder of the socket's drop-ins
  std::string announcement = kDefaultAnnouncement;  // for avahi-daemon
  std::vector<int> host_ports{};                    // ports that are no page's
};

// Asks for a new password, on a terminal twice and without echo, otherwise by a line of standard input, and
// stores its hash and a new key for slicers. On a terminal, also asks whether to listen on this computer's
// addresses in the local network, and shows the page's address as a QR code. Returns the exit code.
int set_password(const WebFiles& files);

// Asks for the password of another role than print, which must have one, and stores its hash; or removes that
// role's password. The key and the other passwords stay. Returns the exit code. Throws std::runtime_error.
int set_role_password(Role role, bool remove, const WebFiles& files);

// Makes the service listen on these addresses from its next start on; without any, prints the addresses, on a
// terminal with a QR code.
// Throws std::runtime_error for an address that is none.
int set_addresses(const std::vector<std::string>& addresses, const WebFiles& files);

// Turns the page off: removes the password and the announcement. Returns the exit code.
int turn_off(const WebFiles& files);

}  // namespace contourd::web
