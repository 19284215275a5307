#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

void add_status(Command& program) {
  add_request(program, "status", "Show the current activity of the printer", "status");
}

void add_print_control(Command& program) {
  add_request(program, "pause", "Pause the print after the current layer", "pause");
  add_request(program, "resume", "Continue after a pause, or release the queue after a failure", "resume");
  add_request(program, "cancel", "Cancel the current print: light off, plate up", "cancel");
  add_request(program, "plate-cleared", "Confirm that the plate is free for the next job", "plate_cleared");
}

}  // namespace contourd::ctl
