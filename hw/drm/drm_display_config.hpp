// Which output shows the masks, and how. Value type.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/units.hpp"
#include "hw/drm/pixel_format.hpp"

namespace contourd {

struct DrmDisplayConfig {
  std::optional<std::string>
      card;  // "/dev/dri/card1" or a driver's name ("vc4"); else the first with a connected output
  std::optional<std::string> connector;  // "HDMI-A-1"; else the first that is connected
  Pixels width{1920};
  Pixels height{1080};
  double refresh_hz = 60.0;  // of the mode, within half a hertz

  using Format = PixelFormat;
  Format format = Format::Xrgb8888;
  // For masks; black has one of its own. With 3, a buffer that left the screen is not written until the next
  // one has left it too: for drivers that still read it after they said that they have flipped.
  int buffers = 2;  // 2 or 3

  bool legacy = false;            // use the old calls even where the driver has the atomic ones
  bool ignore_edid_size = false;  // the picture size that the display reports is wrong: ask nothing of it
};

}  // namespace contourd
