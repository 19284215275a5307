// Which output shows the masks, and how. Value type.
#pragma once

#include <optional>
#include <string>

#include "core/units.hpp"

namespace contourd {

struct DrmDisplayConfig {
  std::optional<std::string>
      card;  // "/dev/dri/card1" or a driver's name ("vc4"); else the first with a connected output
  std::optional<std::string> connector;  // "HDMI-A-1"; else the first that is connected
  Pixels width{1920};
  Pixels height{1080};
  double refresh_hz = 60.0;  // of the mode, within half a hertz

  enum class Format { Xrgb8888, Rgb565 };
  Format format = Format::Xrgb8888;
  int buffers = 2;  // 2 or 3
};

}  // namespace contourd
