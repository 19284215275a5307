// A line that turns the light on: an LED driver's enable, or a shutter. Event loop's thread only.
#pragma once

#include <optional>
#include <string>

#include "hw/clock.hpp"
#include "hw/hardware_error.hpp"
#include "hw/interface.hpp"

namespace contourd {

// The error when an open interlock keeps the light from being turned on. The light is off and not at fault.
class LightInterlocked : public HardwareError {
 public:
  using HardwareError::HardwareError;
};

// The destructor leaves the light off.
class LightLine : public Interface {
 public:
  // Turns the light on. Throws LightInterlocked if an interlock is open, another HardwareError if the line
  // cannot be set.
  virtual void on() = 0;
  virtual void off() noexcept = 0;
  // Returns, in a sentence, why the line is not off although it should be; empty if it is off, or is meant to
  // be on.
  [[nodiscard]] virtual std::string refusal() const = 0;
  // Returns the earliest time at which a safety cutoff turned the line off; nullopt unless it is being kept
  // off.
  [[nodiscard]] virtual std::optional<TimePoint> cut_at() const = 0;
  // Returns the time by which that cutoff had certainly turned the line off; nullopt if unknown.
  [[nodiscard]] virtual std::optional<TimePoint> cut_by() const = 0;
};

// An interface by which a thread that cannot wait for the event loop turns the light off.
class LightCutoff : public Interface {
 public:
  // Turns the light off and keeps it off until release(). May be called from any thread; neither allocates,
  // locks nor throws.
  virtual void cut(TimePoint now) noexcept = 0;
  // Allows the light again but does not turn it on. Event loop's thread only.
  virtual void release() noexcept = 0;
};

}  // namespace contourd
