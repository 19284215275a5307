// The config of the output that shows the masks. Value type.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/units.hpp"
#include "hw/drm/pixel_format.hpp"

namespace contourd {

struct DrmDisplayConfig {
  std::optional<std::string>
      card;  // "/dev/dri/card1" or a driver's name ("vc4"); if unset the first with a connected output
  std::optional<std::string> connector;  // "HDMI-A-1"; if unset the first that is connected
  Pixels width{1920};
  Pixels height{1080};
  double refresh_hz = 60.0;  // a mode's refresh may differ by half a hertz

  using Format = PixelFormat;
  Format format = Format::Xrgb8888;
  // The number of buffers for masks; black has its own. With 3, a buffer that has left the screen is not
  // written until the next one has left it too, for drivers that still read a buffer after they reported the
  // flip away from it.
  int buffers = 2;  // 2 or 3

  bool legacy = false;            // use the legacy calls even if the driver supports atomic calls
  bool ignore_edid_size = false;  // ignore the picture size that the display reports, because it is wrong
};

}  // namespace contourd
