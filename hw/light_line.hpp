// A line that turns the light on: an LED driver's enable, or a shutter. Event loop's thread only.
#pragma once

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
};

}  // namespace contourd
