// What a machine, or one of its devices, tells by itself. A value type.
#pragma once

#include <string>
#include <vector>

namespace contourd {

// Something that happened to the machine and that nobody asked it for.
struct Disturbance {
  enum class Kind {
    Interruption,  // the lid was opened, the display unplugged: a print may go on when that has been seen to
    Fault,         // the emergency stop was pressed, steps were lost: the print is over
    Recovery,      // what was in the way no longer is: the lid is closed, the display plugged in again
    Notice,        // lost steps were made good: nothing is in the way, but the owner should know
  };
  Kind kind = Kind::Fault;
  std::string what;  // one sentence, with the line, connector or port
  // Somebody had a reason to stop everything, or has let the stop go: nothing moves by itself after that.
  bool owner_decides = false;
  // What an owner should know of a device that has come, though it works; a sentence each.
  std::vector<std::string> warnings{};
};

}  // namespace contourd
