// The interface that all devices of a machine share. The defaults are those of a device that has no events of
// its own and cannot be lost. Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "hw/interface.hpp"

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

class Device : public Interface {
 public:
  // Runs `call` from the event loop for every machine event from now on. A device without events drops it.
  virtual void on_event(std::function<void(const MachineEvent&)> call) {
    [[maybe_unused]] const auto dropped = std::move(call);
  }
  // True if this object has lost its device for good. Once this object is destroyed, the device may be opened
  // again.
  [[nodiscard]] virtual bool lost() const { return false; }
  // Returns what keeps the machine from printing at this moment, one sentence per reason.
  [[nodiscard]] virtual std::vector<std::string> why_not_ready() const = 0;
  // Returns the device as a user knows it: "Optoma at /dev/ttyUSB0".
  [[nodiscard]] virtual std::string description() const = 0;
  // Returns problems that do not keep the device from working, one sentence per problem.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace contourd
