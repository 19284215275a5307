// contourctl's commands for manual control. Each blocks until the operation has ended. If contourctl is
// interrupted or killed, the daemon stops the operation, because the connection is lost.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// The event for which a command waits.
enum class WaitFor {
  Operation,  // the end of the operation
  Picture,    // the end of the picture
  Rest,       // the end of manual control, with the light off
};
// Sends the request, prints each phase, and waits. Returns the exit code.
int control_by_hand(const ClientOptions& options, const Request& request, WaitFor what);

// Powers the projector on and waits until its lamp is warm, or powers it off. Prints the result and returns
// the exit code.
int power_projector(const ClientOptions& options, bool on);

struct ShowOptions {
  std::string what;  // a pattern's name, a PNG file, or with `at_z_mm` a model's file
  std::optional<double> seconds;
  std::optional<double> at_z_mm;  // height above the plate of the mask to show
  std::filesystem::path printer;  // configuration for that mask
  std::optional<std::filesystem::path> ticket;
};

// Shows the picture until it ends. Returns the exit code.
int show_by_hand(const ClientOptions& options, const ShowOptions& show);

// Turns the light on after the user has confirmed it, and waits until it is off. `confirmed`: do not ask.
// Returns the exit code. Throws UsageError if standard input is not a terminal and `confirmed` is false.
int light_by_hand(const ClientOptions& options, const Request& request, bool confirmed);

// Returns "found 1.3 um higher than at the previous homing".
std::string describe_homing_shift(double shift_um);

// Prints the part of the status that concerns manual control.
void print_manual(const nlohmann::ordered_json& status);

}  // namespace contourd::ctl
