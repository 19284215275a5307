// An interface by which a thread that cannot wait for the event loop turns the light off.
#pragma once

#include "hw/clock.hpp"

namespace contourd {

class LightCutoff {
 public:
  LightCutoff() = default;
  LightCutoff(const LightCutoff&) = delete;
  LightCutoff& operator=(const LightCutoff&) = delete;
  virtual ~LightCutoff() = default;

  // Turns the light off and keeps it off until release(). May be called from any thread; neither allocates,
  // locks nor throws.
  virtual void cut(TimePoint now) noexcept = 0;
  // Allows the light again but does not turn it on. Event loop's thread only.
  virtual void release() noexcept = 0;
};

}  // namespace contourd
