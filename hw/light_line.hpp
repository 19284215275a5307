// A line that turns the light on: an LED driver's enable, or a shutter. Event loop's thread only.
#pragma once

#include <optional>
#include <string>

#include "hw/clock.hpp"
#include "hw/hardware_error.hpp"

namespace contourd {

// The light was not turned on, and is off, because an interlock is open: no fault of the light's.
class LightInterlocked : public HardwareError {
 public:
  using HardwareError::HardwareError;
};

class LightLine {
 public:
  LightLine() = default;
  LightLine(const LightLine&) = delete;
  LightLine& operator=(const LightLine&) = delete;
  virtual ~LightLine() = default;  // leaves the light off

  // Throws LightInterlocked, and another HardwareError when the line cannot be set.
  virtual void on() = 0;
  virtual void off() noexcept = 0;
  // Why the line is not off though it should be, in a sentence; empty when it is off, or is meant to be on.
  [[nodiscard]] virtual std::string refusal() const = 0;
  // When it was put off for people's safety, not before, and is kept off; nothing when it is not.
  [[nodiscard]] virtual std::optional<TimePoint> cut_at() const = 0;
  // By when it was off then; nothing when nobody knows.
  [[nodiscard]] virtual std::optional<TimePoint> cut_by() const = 0;
};

}  // namespace contourd
