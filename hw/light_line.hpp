// A line that turns the light on: an LED driver's enable, or a shutter. Event loop's thread only.
#pragma once

#include <string>

namespace contourd {

class LightLine {
 public:
  LightLine() = default;
  LightLine(const LightLine&) = delete;
  LightLine& operator=(const LightLine&) = delete;
  virtual ~LightLine() = default;  // leaves the light off

  // Throws HardwareError when the line cannot be set.
  virtual void on() = 0;
  virtual void off() noexcept = 0;
  // Why the line is not off though it should be, in a sentence; empty when it is off, or is meant to be on.
  [[nodiscard]] virtual std::string refusal() const = 0;
};

}  // namespace contourd
