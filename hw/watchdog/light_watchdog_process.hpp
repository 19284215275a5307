// The light watchdog: a process that turns the light off when the daemon does not, or no longer can. It does
// nothing else, allocates no memory once it has started, and blocks the signals that end the daemon: it ends
// when the daemon has ended and the light is off.
#pragma once

#include "hw/watchdog/light_watchdog.hpp"

namespace contourd {

// The option that runs this process: `contourd --light-watchdog FD`.
inline constexpr const char* kLightWatchdogOption = "--light-watchdog";
// Starts this program again with that option. Thread-safe. Throws std::system_error.
[[nodiscard]] LightWatchdog::Process start_light_watchdog();

// Runs the watchdog until the other end of the socket (SOCK_SEQPACKET, see watchdog_message.hpp) is closed
// and the light is off. Closes every descriptor above `socket`. For a process with one thread that does
// nothing else. Returns the exit status.
[[nodiscard]] int serve_light_watchdog(int socket) noexcept;

}  // namespace contourd
