// What every device of a machine can be asked, whatever it is. Event loop's thread only.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hw/disturbance.hpp"

namespace contourd {

class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  // `call` runs from the event loop for every disturbance from now on.
  virtual void on_disturbance(std::function<void(const Disturbance&)> call) = 0;
  // For good: closed, it may be found again.
  [[nodiscard]] virtual bool lost() const = 0;
  // What keeps the machine from printing at this moment, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> why_not_ready() const = 0;
  // As an owner knows it: "Optoma at /dev/ttyUSB0".
  [[nodiscard]] virtual std::string description() const = 0;
  // What an owner should know though it works, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> warnings() const = 0;
};

}  // namespace contourd
