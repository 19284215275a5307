// An event that a machine, or one of its devices, reports on its own. A value type.
#pragma once

#include <string>
#include <vector>

namespace contourd {

// An event that is not the answer to a command.
struct MachineEvent {
  enum class Kind {
    Interlock,  // the lid was opened, the display unplugged: the print may continue once that is resolved
    Fault,      // the emergency stop was pressed, steps were lost: the print is over
    Recovery,   // the obstacle is gone: the lid is closed, the display plugged in again
    Notice,     // lost steps were corrected: the print can go on, but the user should know
  };
  Kind kind = Kind::Fault;
  std::string what;  // one sentence, with the line, connector or port
  // True if the emergency stop was pressed or released: nothing moves until the user allows it.
  bool needs_user = false;
  // Problems of a device that has come back and works in spite of them, one sentence each.
  std::vector<std::string> warnings{};
};

}  // namespace contourd
