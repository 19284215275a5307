// Handles with which another process can turn the light off. Value types.
#pragma once

#include <cstdint>
#include <string>

#include "hw/clock.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {

// The descriptors are borrowed; -1 if there is no such device, or no longer.
struct LightSerialPath {
  int descriptor = -1;
  std::string light_off;
  Duration gap{};  // from one light off to the next: the projector's gap plus the command's time on the wire
};
struct LightDisplayPath {
  int descriptor = -1;
  std::uint32_t crtc = 0, connector = 0, black = 0;  // `black` is a framebuffer
  DisplayModeBytes mode{};
};

}  // namespace contourd
