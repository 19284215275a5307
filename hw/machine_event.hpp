// An event that a machine, or one of its devices, reports by itself. A value type.
#pragma once

#include <string>
#include <vector>

namespace contourd {

// An event that is no answer to a command.
struct MachineEvent {
  enum class Kind {
    Interlock,  // the lid was opened, the display unplugged: a print may go on when that has been seen to
    Fault,      // the emergency stop was pressed, steps were lost: the print is over
    Recovery,   // what was in the way no longer is: the lid is closed, the display plugged in again
    Notice,     // lost steps were made good: nothing is in the way, but the owner should know
  };
  Kind kind = Kind::Fault;
  std::string what;  // one sentence, with the line, connector or port
  // The emergency stop was pressed or released: nothing moves until the owner says so.
  bool owner_decides = false;
  // Problems of a device that has come back, though it works; a sentence each.
  std::vector<std::string> warnings{};
};

}  // namespace contourd
