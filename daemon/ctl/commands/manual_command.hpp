// Shared code of contourctl's commands for manual control, level and setup. Each command blocks until its
// operation has ended. If contourctl is interrupted or killed, the daemon stops the operation, because the
// connection is lost.
#pragma once

#include <string>

#include "core/mask/mask.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Help text of an option that several commands have.
inline constexpr const char* kPlateIsClearHelp = "Declare that nothing is in the plate's way";

// The event for which a command waits.
enum class WaitFor {
  Operation,  // the end of the operation
  Picture,    // the end of the picture
  Rest,       // the end of manual control, with the light off
};
// The output of an operation: its phases and its result, or nothing unless it fails.
enum class Progress { Printed, Hidden };
// Sends the request, and waits. Returns the exit code.
int control_by_hand(const ClientOptions& options, const Request& request, WaitFor what,
                    Progress progress = Progress::Printed);

// A picture on the display, black again at this object's end. Not thread-safe; blocks.
class ShownPicture {
 public:
  // Throws DaemonError if contourd cannot be reached or refuses the picture.
  ShownPicture(const ClientOptions& options, const Mask& picture);

 private:
  DaemonConnection connection_;  // contourd ends the picture with it
};

// Describes the limit switch's shift since the previous homing: "found 1.3 um higher than at the previous
// homing".
std::string describe_homing_shift(double shift_um);

}  // namespace contourd::ctl
