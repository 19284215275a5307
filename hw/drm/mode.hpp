// Display modes: the choice of the mode that the config asks for, and the check that it can show masks.
// Output chooses when it opens or restores a display, and --check-hardware chooses to report the mode. Pure
// functions on the kernel's list of modes; thread-safe.
#pragma once

#include <xf86drmMode.h>

#include <optional>
#include <span>
#include <string>

#include "hw/drm/drm_display_config.hpp"

namespace contourd {

using Mode = drmModeModeInfo;

// Returns the pictures per second, computed from the pixel clock: the kernel's vrefresh is rounded and cannot
// tell 59.94 from 60.
[[nodiscard]] double refresh_hz(const Mode& mode);

// "1920x1080 at 59.94 Hz", with its peculiarities: "1920x1080 at 60.00 Hz, interlaced".
[[nodiscard]] std::string describe(const Mode& mode);
// "1280x720 at 60.00 Hz; 1920x1080 at 60.00 Hz", each once; "none" if there are no modes.
[[nodiscard]] std::string describe(std::span<const Mode> modes);

// True if a display cannot tell the modes apart. Their names may differ.
[[nodiscard]] bool same_timing(const Mode& a, const Mode& b);

// The size of the whole picture from EDID. 0 if it is unknown, as it usually is for projectors.
struct PictureSize {
  int width_mm = 0, height_mm = 0;
};

// Returns the reason why this mode cannot show masks, or nullopt if it can. It cannot if it sends half
// pictures, lines or pixels twice, a picture for each eye, or if its pixels are not square. Pixels are square
// if
//  - the picture's aspect ratio that the mode names (CEA-861), and
//  - the picture's size, if both sides are known, for some size that rounds to it (EDID has centimetres),
// give pixels that are as wide as high to 1 %.
[[nodiscard]] std::optional<std::string> why_unsuitable(const Mode& mode, PictureSize size);

// Returns the mode that the config asks for. It has exactly the wanted size and the nearest refresh, within
// half a hertz; of equally near modes it is the one that the display prefers, else the first. Throws
// HardwareError that names `output` ("HDMI-A-1 of /dev/dri/card0 (vc4)") and lists the modes if none fits.
[[nodiscard]] Mode choose_mode(std::span<const Mode> modes, PictureSize size, const DrmDisplayConfig& config,
                               const std::string& output);

}  // namespace contourd
