// The light watchdog: a process that turns the light off when the daemon does not, or no longer can. It does
// nothing else, takes no memory once it has started, and is deaf to the signals that end the daemon: it ends
// when the daemon has, and the light is off.
#pragma once

#include "hw/watchdog/light_watchdog.hpp"

namespace contourd {

// `contourd --light-watchdog FD` is this process.
inline constexpr const char* kLightWatchdogOption = "--light-watchdog";
// Starts this program anew with that option. Thread-safe. Throws std::system_error.
[[nodiscard]] LightWatchdog::Process start_light_watchdog();

// Serves until the other end of the socket (SOCK_SEQPACKET, see watchdog_message.hpp) is closed. Closes every
// other descriptor above it. To be the whole of a process with one thread. Returns the exit status.
[[nodiscard]] int serve_light_watchdog(int socket) noexcept;

}  // namespace contourd
