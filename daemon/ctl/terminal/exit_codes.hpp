// contourctl's exit codes (BSD's sysexits.h) and the exceptions that lead to them. kBadUsage and
// kCannotCreate are in daemon/system/standard_output.hpp, because contourd uses them, too.
#pragma once

#include <stdexcept>

#include "daemon/client/daemon_error.hpp"
#include "daemon/system/standard_output.hpp"  // IWYU pragma: export

namespace contourd::ctl {

inline constexpr int kOk = 0;
inline constexpr int kFailed = 1;        // the daemon refused, or the print failed
inline constexpr int kBadData = 65;      // EX_DATAERR; also a model that the printer cannot print
inline constexpr int kNoInput = 66;      // EX_NOINPUT: a file cannot be read
inline constexpr int kUnavailable = 69;  // EX_UNAVAILABLE: the daemon cannot be reached
inline constexpr int kBadConfig = 78;    // EX_CONFIG: the printer's configuration or a ticket is wrong

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace contourd::ctl
