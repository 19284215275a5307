// What a thread that cannot wait for the event loop turns the light off by.
#pragma once

#include "hw/clock.hpp"

namespace contourd {

class LightCutoff {
 public:
  LightCutoff() = default;
  LightCutoff(const LightCutoff&) = delete;
  LightCutoff& operator=(const LightCutoff&) = delete;
  virtual ~LightCutoff() = default;

  // The light, which may be on until now, goes off and stays off until release(). Any thread; neither
  // allocates, locks nor throws.
  virtual void cut(TimePoint now) noexcept = 0;
  // The light may go on again, which it does not by itself. Event loop's thread only.
  virtual void release() noexcept = 0;
};

}  // namespace contourd
