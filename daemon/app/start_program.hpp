// The program contourd: parses the command line and wires the machine, the printer service and the event
// loop.
#pragma once

namespace contourd {

// Exit codes of BSD's sysexits.h, besides kBadUsage and kCannotCreate. systemd does not restart contourd
// after 78 (see contourd.service).
inline constexpr int kMissingDevice = 69, kFailed = 70, kRestart = 75, kBadConfig = 78;

// Does what the command line asks for, and returns the exit code. Blocks until the program ends. Throws
// ConfigError for a configuration that cannot be used, and std::exception for other failures.
[[nodiscard]] int start_program(int argc, char** argv);

}  // namespace contourd
