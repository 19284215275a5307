// What contourctl has the printer do by hand. Blocks until that is over; whatever ends contourctl before ends
// it too, since the connection is gone then.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Sends the request, says what happens, and waits until it is over. Returns the exit code.
enum class WaitFor {
  Operation,  // to its end
  Picture,    // until it is shown no more
  Rest,       // until nothing is done by hand any more, and it is dark
};
int control_by_hand(const ClientOptions& options, const Request& request, WaitFor what);

// Powers the projector on, until its lamp is warm, or off. Says which at the end.
int power_projector(const ClientOptions& options, bool on);

struct ShowOptions {
  std::string what;  // a pattern's name, a PNG file, or with `at_z_mm` a model's file
  std::optional<double> seconds;
  std::optional<double> at_z_mm;  // above the plate: the model's mask there, by
  std::filesystem::path printer;  // this configuration
  std::optional<std::filesystem::path> ticket;
};

// Shows that until it is shown no more.
int show_by_hand(const ClientOptions& options, const ShowOptions& show);

// The same for light, for which a person has to say yes; `confirmed`: that was said already. Throws
// UsageError where nobody can be asked.
int light_by_hand(const ClientOptions& options, const Request& request, bool confirmed);

// "found 1.3 um higher than by the homing before".
std::string describe_homing_shift(double shift_um);

// What the status says of what is done by hand.
void print_manual(const nlohmann::ordered_json& status);

}  // namespace contourd::ctl
