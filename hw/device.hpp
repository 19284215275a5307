// What every device of a machine can be asked, whatever it is. Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hw/machine_event.hpp"

namespace contourd {

class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  // `call` runs from the event loop for every machine event from now on.
  virtual void on_event(std::function<void(const MachineEvent&)> call) = 0;
  // Whether it is gone for good. It may be opened again after it was closed.
  [[nodiscard]] virtual bool lost() const = 0;
  // What keeps the machine from printing at this moment, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> why_not_ready() const = 0;
  // As an owner knows it: "Optoma at /dev/ttyUSB0".
  [[nodiscard]] virtual std::string description() const = 0;
  // Problems that do not keep it from working, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> warnings() const = 0;
};

}  // namespace contourd
